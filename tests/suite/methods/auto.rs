//! `method = "auto"` of the model: which links get the method that keeps their energy, and which stay explicit.

use super::stable::{made, only_falls, ran};
use crate::play::model;
use ca_compile::{Compiled, Options, compile};
use ca_core::Level;
use ca_model::Model;
use ca_tests::catalog;

/// A hammer of 100 times the stiffness that an explicit contact bears, a cubic spring, a plectrum and a bow.
const MODEL: &str = r#"
[model]
method = "auto"
[SOL]
wall = {}
[CEL]
bar = { m = "2 g", f = "330 Hz", t60 = "1 s" }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "0.8 m/s" }
weight = { m = "3 g", dx0 = "1 mm" }
reed = { m = "1 g", dx0 = "-0.1 mm" }
[RES]
back = { between = ["wall", "reed"], k = "400 N/m" }
[CUB]
sling = { between = ["wall", "weight"], k = "300 N/m", k3 = 1e9 }
[BUT]
strike = { between = ["hammer", "bar"], k = "50 MN/m", z = "0.5 N s/m" }
[BOW]
rub = { between = ["weight", "reed"], f = "0.1 N", v0 = "50 mm/s" }
[SOX]
left = { from = "bar" }
right = { from = "reed" }
"#;

fn compiled(text: &str) -> Compiled {
    let m = model(text);
    compile(&m, &catalog(), &Options { energy: true, ..Options::default() }).unwrap_or_else(|d| panic!("{d:?}"))
}

fn laws(c: &Compiled) -> Vec<&'static str> {
    ran(&c.scene)
}

fn notes(c: &Compiled) -> Vec<String> {
    c.findings.list.iter().filter(|d| d.code == "N207").map(|d| d.title.clone()).collect()
}

#[test]
fn each_law_has_the_method_that_keeps_its_energy() {
    let auto = compiled(MODEL);
    assert_eq!(auto.certificate.level, Level::Proven);
    assert!(notes(&auto).is_empty());
    let written = MODEL
        .replace("method = \"auto\"", "")
        .replace("k3 = 1e9 }", "k3 = 1e9, method = \"stable\" }")
        .replace("z = \"0.5 N s/m\" }", "z = \"0.5 N s/m\", method = \"stable\" }")
        .replace("v0 = \"50 mm/s\" }", "v0 = \"50 mm/s\", method = \"newton\" }");
    let by_hand = compiled(&written);
    assert_eq!(laws(&auto), laws(&by_hand));
    let state = only_falls(&auto, 48_000, 1e-11, MODEL, |_| {});
    assert!(made(&state) <= 1e-11);
    // the same sound to the bit
    let sound = |c: &Compiled| {
        let mut s = c.scene.state();
        (0..20_000)
            .map(|_| (ca_core::tick(&c.scene, &mut s), s.output[0].to_bits(), s.output[1].to_bits()))
            .collect::<Vec<_>>()
    };
    assert_eq!(sound(&auto), sound(&by_hand));
}

#[test]
fn a_method_that_a_line_names_counts_and_so_does_that_of_a_group() {
    let text = MODEL.replace("z = \"0.5 N s/m\" }", "z = \"0.5 N s/m\", method = \"ca\" }");
    assert!(laws(&compiled(&text)).contains(&"BUT"));
    let grouped = "[model]\nmethod = \"auto\"\n[near]\nmethod = \"ca\"\n[near.MAS]\na = { m = 1e-3, v = 1 }\n[near.SOL]\nw = { x = 1e-3 }\n\
        [near.BUT]\nc = { between = [\"near.a\", \"near.w\"], k = 1e3 }\n[SOX]\no = { from = \"near.a\" }\n";
    assert_eq!(laws(&compiled(grouped))[0], "BUT");
}

/// A link without a method that works stays explicit and is named; all others conserve their energy.
#[test]
fn what_cannot_be_stays_explicit_and_is_named() {
    let moving = "[model]\nmethod = \"auto\"\n[param]\nu = { value = 0.5, live = true, min = 0.1, max = 0.9 }\n\
        [STRING]\nlow = { n = 20, f = 110, t60 = 3, m = 1e-3 }\n[MAS]\nhammer = { m = 5e-3, x = -1e-3, v = 1 }\n\
        pick = { m = 5e-3, x = -1e-3, v = 1 }\n[BUT]\nstrike = { between = [\"hammer\", \"low@u\"], k = 1e3 }\n\
        again = { between = [\"pick\", \"low[3]\"], k = 1e3 }\n[SOX]\no = { from = \"low[2]\" }\n";
    let c = compiled(moving);
    assert_eq!(laws(&c).iter().filter(|l| l.starts_with("BUT")).count(), 2, "{:?}", laws(&c));
    assert!(laws(&c).contains(&"BUT") && laws(&c).contains(&"BUT stable"), "{:?}", laws(&c));
    assert_eq!(notes(&c).len(), 1);
    assert!(notes(&c)[0].contains("`strike`") && notes(&c)[0].contains("moving point"), "{:?}", notes(&c));

    // an implicit spring that its author wrote goes before a contact that `auto` chose
    let beside = "[model]\nmethod = \"auto\"\n[SOL]\nw = { x = 1e-3 }\n[MAS]\na = { m = 1e-3, v = 1 }\n\
        [REF]\ns = { between = [\"w\", \"a\"], k = 1e3, method = \"implicit\" }\n[BUT]\nc = { between = [\"a\", \"w\"], k = 1e3 }\n\
        [SOX]\no = { from = \"a\" }\n";
    let c = compiled(beside);
    assert!(laws(&c).contains(&"BUT"), "{:?}", laws(&c));
    assert_eq!(notes(&c).len(), 1, "{:?}", c.findings);

    // an error of the model is said as it is
    let wrong: Model = model(&MODEL.replace("k = \"400 N/m\"", "k = \"400 N/m\", method = \"newton\""));
    let found = compile(&wrong, &catalog(), &Options::default()).expect_err("no such method");
    assert!(found.list.iter().all(|d| d.code != "N207"), "{found:?}");
}

/// `format` decides the default, and only that.
#[test]
fn from_format_2_on_auto_is_the_default() {
    let with = |head: &str| MODEL.replace("method = \"auto\"", head);
    assert_eq!(laws(&compiled(&with("format = 2"))), laws(&compiled(MODEL)));
    assert_eq!(laws(&compiled(&with("format = 1"))), laws(&compiled(&with(""))));
    assert_eq!(laws(&compiled(&with("format = 2\nmethod = \"ca\""))), laws(&compiled(&with(""))));
    for wrong in ["format = 3", "format = 1.5", "format = 0", "format = \"two\""] {
        let found = compile(&model(&with(wrong)), &catalog(), &Options::default()).expect_err(wrong);
        assert!(found.has_errors(), "{wrong}");
    }
}

/// Few pairs of a set become single links, whose energy is conserved; many stay one module.
#[test]
fn a_small_set_of_pairs_is_conserved() {
    let text = |n: u32, format: u32| {
        format!(
            "[model]\nformat = {format}\n[air]\ndim = 3\n[air.GRAINS]\ng = {{ n = {n}, m = \"0.3 g\", gap = \"8 mm\" }}\n\
             [BUT]\nclack = {{ between = [\"air.g[*]\", \"air.g[*]\"], k = 5e5, d = \"9 mm\" }}\n[SOX]\no = {{ from = \"air.g[0]\", along = \"x\" }}\n"
        )
    };
    let few = compiled(&text(12, 2));
    assert_eq!(few.certificate.level, Level::Proven);
    assert!(laws(&few).contains(&"BUT stable3d"), "{:?}", laws(&few));
    only_falls(&few, 9_600, 1e-11, &text(12, 2), |_| {});
    for text in [text(12, 1), text(40, 2)] {
        assert!(laws(&compiled(&text)).contains(&"BUT"), "{text}");
    }
    let left = notes(&compiled(&text(40, 2)));
    assert!(left[0].contains("a set of 780 pairs"), "{left:?}");
}

/// A contact across two worlds at a modal mass stays explicit and is named.
#[test]
fn a_contact_across_two_worlds_at_a_modal_mass_stays_explicit() {
    let text = "[model]\nformat = 2\n[w]\nmethod = \"modal\"\n[w.STRING]\nst = { n = 9, m = 1e-3, f = 200 }\n[air]\ndim = 3\n\
                [air.SOL]\nnail = {}\n[air.MAS]\nball = { m = \"5 g\", x = [\"12 mm\", \"16 mm\", 0], v = [-0.6, -0.8, 0] }\n\
                [SOL]\nwall = {}\n[LPR_BUT]\nedge = { between = [\"air.nail\", \"air.ball\"], onto = [\"wall\", \"w.st[4]\"], \
                k = \"20 kN/m\", d = \"10 mm\" }\n[SOX]\no = { from = \"w.st[2]\" }\n";
    let c = compiled(text);
    assert!(laws(&c).contains(&"LPR_BUT"), "{:?}", laws(&c));
    assert!(notes(&c)[0].contains("acts on two worlds"), "{:?}", notes(&c));
}
