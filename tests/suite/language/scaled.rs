//! A number times a parameter, `"6.27 f"`, equals the product written out.

use crate::play::{model, off, within};
use ca_compile::{Options, analysis::modes::modes, load};
use ca_model::{Model, render};
use ca_tests::catalog;

/// Two instances of a part with a bank of cells `bank`, the second of 330 Hz; `param` adds parameters.
fn tines(param: &str, bank: &str) -> String {
    format!(
        "[part.tine.param]\nf = {{ unit = \"Hz\", doc = \"pitch\" }}\n{param}\n\
         [part.tine.BANK]\nbar = {{ {bank} }}\n\
         [use]\ntine = {{ part = \"tine\", n = 2, with = {{ f = [\"A3\", 330] }} }}\n\
         [SOX]\nout = {{ from = \"tine[*].bar[*]\", gain = 1, channel = 0 }}\n"
    )
}

/// Pitches of a model by its modes, lowest first \[Hz\].
fn pitches(model: &Model) -> Vec<f64> {
    let network = ca_compile::linear(model, &catalog(), &Options::default())
        .unwrap_or_else(|found| panic!("{}", render::text(&found, model, false)));
    modes(&network).expect("they are found").list.iter().map(|m| m.heard).collect()
}

fn errors(text: &str) -> String {
    let (model, result) = load(text, "m.ca.toml", &catalog(), &Options::default());
    let found = result.err().unwrap_or_else(|| panic!("nothing is wrong in\n{text}"));
    render::text(&found, &model, false)
}

fn sounds(text: &str, want: [f64; 4]) {
    let found = pitches(&model(text));
    assert_eq!(found.len(), want.len(), "{text}");
    for (is, want) in found.iter().zip(want) {
        within(&format!("{want} Hz"), off(*is, want), 1e-9);
    }
}

const WANT: [f64; 4] = [220.0, 330.0, 6.27 * 220.0, 6.27 * 330.0];

#[test]
fn a_number_times_a_parameter_is_the_product_in_each_instance() {
    let bank = "m = \"2 g\", f = [\"f\", \"6.27 f\"], t60 = \"1 s\"";
    sounds(&tines("", bank), WANT);
    // a default, and a default derived from it
    let bank = bank.replace("6.27 f", "3 half");
    sounds(&tines("over = { value = \"4.18 f\" }\nhalf = { value = \"0.5 over\" }", &bank), WANT);
    // a plain number, and a list passed as a whole
    let bank = "m = \"2 g\", f = \"all\", t60 = \"2 half\"";
    sounds(&tines("half = 0.5\nall = { value = [\"f\", \"6.27 f\"] }", bank), WANT);
    // passed to an inner part and scaled there again
    let text = "[part.in.param]\ntone = {}\n[part.in.BANK]\nbar = { m = \"2 g\", f = [\"tone\", \"3.135 tone\"], t60 = 1 }\n\
                [part.out.param]\nf = {}\n[part.out.use]\nin = { part = \"in\", with = { tone = \"2 f\" } }\n\
                [use]\no = { part = \"out\", n = 2, with = { f = [\"110 Hz\", \"165 Hz\"] } }\n\
                [SOX]\nout = { from = \"o[*].in.bar[*]\", gain = 1, channel = 0 }\n";
    sounds(text, [220.0, 330.0, 3.135 * 220.0, 3.135 * 330.0]);
}

#[test]
fn a_product_follows_what_is_set_and_is_found_in_a_model_written_flat() {
    let mut it = model(&tines("", "m = \"2 g\", f = [\"f\", \"2 f\"], t60 = \"1 s\""));
    assert!(it.set("tine[1].f", "440 Hz"));
    let flat = model(&ca_model::write::write(&it));
    for m in [&it, &flat] {
        let found = pitches(m);
        for (is, want) in found.iter().zip([220.0, 440.0, 440.0, 880.0]) {
            within(&format!("{want} Hz"), off(*is, want), 1e-9);
        }
    }
}

#[test]
fn a_number_of_midi_is_scaled_too_and_a_unit_comes_before_a_parameter() {
    let text = "[part.p.param]\ngap = \"-2 mm\"\nm = \"3 g\"\n\
                [part.p.TGR]\nkey = { x = \"2 gap\", midi = { note = 60, from = \"2 gap\", to = \"-1.5 gap\" } }\n\
                [part.p.MAS]\na = { m = \"m\", dx0 = \"4 m\" }\n[part.p.RES]\nr = { between = [\"key\", \"a\"], k = 9 }\n\
                [use]\np = { part = \"p\" }\n[SOX]\nout = { from = \"p.a\", gain = 1 }\n";
    let scene = crate::play::scene(text).scene;
    let midi = scene.inputs[0].midi.expect("a mapping");
    assert_eq!((scene.inputs[0].rest, midi.from, midi.to), (-0.004, -0.004, 0.003));
    assert_eq!(scene.state().x[crate::play::mat(&scene, "p.a")], 4.0, "four metres");
}

#[test]
fn what_cannot_be_scaled_is_said_to_be_so() {
    let bank = "m = \"2 g\", f = [\"f\", \"6.27 f\"], t60 = \"2 ring\"";
    let live = errors(&tines("ring = { value = 1, unit = \"s\", live = true }", bank));
    assert!(live.contains("[E025]") && live.contains("`tine[0].ring` is live"), "{live}");
    let cel = "[param]\nz = { port = \"key\", span = [0, \"1 mm\"], min = 0, max = \"1 N s/m\" }\n[ENX]\nkey = {}\n\
               [part.p.FRO]\nfelt = { between = [\"key\", \"low\"], z = \"2 z\" }\n[use]\np = { part = \"p\" }\n\
               [CEL]\nlow = { m = 1, f = 9 }\n[SOX]\nout = { from = \"low\" }\n";
    let driven = errors(cel);
    assert!(driven.contains("[E025]") && driven.contains("`z` is live"), "{driven}");
    let near = errors(
        &tines("", &bank.replace("6.27 f", "6.27 pitsh").replace("2 ring", "1 s"))
            .replace("f = {", "pitch = {")
            .replace("[\"f\",", "[\"pitch\",")
            .replace("with = { f", "with = { pitch"),
    );
    assert!(near.contains("did you mean `6.27 pitch`? parameters here: `pitch`"), "{near}");
    let other = errors(&tines("", &bank.replace("2 ring", "2 f")));
    assert!(other.contains("[E008]") && other.contains("must be in s, not in Hz"), "{other}");
    let far = errors(&tines("", &bank.replace("6.27 f", "-1 f").replace("2 ring", "1 s")));
    assert!(far.contains("[E009]") && far.contains("-220 Hz"), "{far}");
    let param =
        errors("[param]\na = 2\nb = \"3 a\"\n[CEL]\nlow = { m = \"b\", f = 9 }\n[SOX]\nout = { from = \"low\" }\n");
    assert!(param.contains("a parameter cannot refer to other parameters"), "{param}");
}
