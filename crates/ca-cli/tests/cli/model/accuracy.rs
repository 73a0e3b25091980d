//! Tests `ca accuracy`: references, orders, Pareto front, recommendation, and page.

use crate::sandbox::Sandbox;
use serde_json::Value as Json;
use std::fs;

fn measured(text: &str, more: &[&str]) -> Json {
    let sandbox = Sandbox::new();
    sandbox.put("model.ca.toml", text);
    let mut args = vec!["accuracy", "model.ca.toml", "--json"];
    args.extend(more);
    serde_json::from_str(&sandbox.ca(&args).is(0).out).expect("JSON")
}

fn row<'a>(found: &'a Json, method: &str, times: u64) -> &'a Json {
    let rows = found["rows"].as_array().expect("rows");
    let here = |r: &&Json| r["method"] == method && r["times"] == times;
    rows.iter().find(here).unwrap_or_else(|| panic!("no {method} x{times} in {found:#}"))
}

fn error(found: &Json, method: &str, times: u64) -> f64 {
    row(found, method, times)["error"].as_f64().unwrap_or(f64::INFINITY)
}

const CHAIN: &str = "[SOL]\nl = {}\nr = {}\n[MAS]\na = { m = \"1 g\", dx0 = \"1 mm\" }\nb = { m = \"1 g\" }\nc = { m = \"1 g\" }\n[RES]\nk = { between = [[\"l\", \"a\", \"b\", \"c\"], [\"a\", \"b\", \"c\", \"r\"]], \
                     k = \"60 kN/m\" }\n[SOX]\nout = { from = \"a\" }\nlow = { from = \"c\" }\n";

/// A linear model is compared with its closed form. Modes are exact, the explicit scheme and theta ¼ have order 2, and
/// theta 1/12 has order 4.
#[test]
fn a_linear_model_has_a_closed_form() {
    let found = measured(CHAIN, &["--seconds", "0.05", "--times", "1,2,4"]);
    assert_eq!(found["reference"]["origin"], "modes");
    assert!(error(&found, "modal", 1) < 1e-10, "{found:#}");
    for (method, order) in [("as written", 2.0), ("implicit 1/4", 2.0), ("implicit 1/12", 4.0)] {
        let rise = (error(&found, method, 2) / error(&found, method, 4)).log2();
        assert!((rise - order).abs() < 0.15, "{method}: {rise}");
    }
    let plain = row(&found, "as written", 1);
    // for 1.22 kHz and above at 48 kHz: docs/numerics.md §1.2
    assert!((0.5..20.0).contains(&plain["cents"].as_f64().expect("a pitch")), "{plain}");
    assert!(row(&found, "modal", 1)["front"] == true && plain["made"].as_f64().is_some_and(|m| m < 1e-12));
}

/// Oversampling keeps the sound rate of the model and has the error of the shorter ticks.
#[test]
fn finer_ticks_are_the_model_as_written() {
    let found = |more: &str| measured(&format!("{CHAIN}{more}"), &["--seconds", "0.05", "--times", "1,4"]);
    let (plain, fine) = (found(""), found("[rate]\noversample = 4\n"));
    assert_eq!((&fine["reference"]["origin"], &fine["rate"]), (&"modes".into(), &plain["rate"]));
    let apart = (error(&fine, "as written", 1) / error(&plain, "as written", 4) - 1.0).abs();
    assert!(apart < 1e-6, "{apart}");
    assert!(error(&fine, "modal", 1) < 1e-9, "{fine:#}");
}

/// A non-linear model is compared with itself at a higher rate, and the uncertainty of that reference is reported.
#[test]
fn another_model_is_its_own_reference() {
    let text = format!("{CHAIN}[CUB]\nhard = {{ between = [\"l\", \"b\"], k3 = \"10 GN/m^3\" }}\n");
    let found = measured(&text, &["--seconds", "0.02", "--times", "1,2,4", "--reference", "64", "--error", "9e-2"]);
    let reference = |found: &Json| {
        let r = &found["reference"];
        assert_eq!(r["origin"], "rate");
        let number = |key: &str| r[key].as_f64().expect("a number");
        (r["method"].as_str().expect("a method").to_owned(), number("order"), number("known"))
    };
    // the method of order 4, where the margin shows its smaller uncertainty
    let (method, order, known) = reference(&found);
    assert!(method == "pefrl" && (order - 4.0).abs() < 0.1, "{found:#}");
    // another method agrees with it
    let second = &found["reference"];
    assert!(second["agrees"] == true && second["second"] == "auto", "{found:#}");
    assert!(second["apart"].as_f64().is_some_and(|apart| apart < 1e-4), "{found:#}");
    assert!(known < 1e-6 * error(&found, "as written", 1), "{found:#}");
    let near = measured(&text, &["--seconds", "0.02", "--times", "1,2,4", "--reference", "16"]);
    let (method, order, known) = reference(&near);
    assert!(method == "as written" && (order - 2.0).abs() < 0.1, "{near:#}");
    assert!(known < 0.02 * error(&near, "as written", 1), "{near:#}");
    // both references give the same error within their uncertainty
    let apart = (error(&near, "as written", 1) - error(&found, "as written", 1)).abs();
    assert!(apart < 2.0 * known, "{apart:e}, {known:e}");
    let rise = (error(&found, "as written", 1) / error(&found, "as written", 4)).log2() / 2.0;
    assert!((rise - 2.0).abs() < 0.15, "{rise}");
    // the recommended row is proven and meets the limit, and no faster one does
    let named = &found["recommended"];
    let best = row(&found, named["method"].as_str().expect("one"), named["times"].as_u64().expect("one"));
    let ns = |r: &Json| r["ns_per_sample"].as_f64().expect("a time");
    assert!(best["method"] == "stable" && best["error"].as_f64().is_some_and(|e| e <= 9e-2), "{best}");
    let good = found["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .filter(|r| r["error"].as_f64().is_some_and(|e| e <= 9e-2) && r["method"] == "stable");
    assert!(good.clone().all(|r| ns(r) >= ns(best)) && good.count() > 1, "{found:#}");
}

/// A diverging model keeps its row but is never recommended. Methods that do not fit the model are named with the
/// reason.
#[test]
fn what_blows_up_is_reported() {
    let text = "[SOL]\nw = {}\n[MAS]\na = { m = \"1 g\", dx0 = \"1 mm\" }\n[RES]\nk = { between = [\"w\", \"a\"], k = \"50 MN/m\" }\n\
                [BUT]\nstop = { between = [\"w\", \"a\"], k = 100, d = \"-1 m\", method = \"stable\" }\n[SOX]\nout = { from = \"a\" }\n";
    let found = measured(text, &["--seconds", "0.01", "--times", "1,8", "--reference", "16", "--error", "2"]);
    let plain = row(&found, "as written", 1);
    assert!(plain["stability"] == "unstable" && plain["front"] == false && plain["error"].is_null(), "{plain}");
    let best = &found["recommended"];
    assert!(best["method"] != "as written" || best["times"] != 1, "{found:#}");
    let why = found["refused"].as_array().expect("a list");
    assert!(why.iter().any(|r| r["method"] == "implicit 1/4"), "{found:#}");
}

/// Compares a mass on a line with the same mass in space, with a much stiffer spring across. The motion along x is the
/// same, so the error is too.
#[test]
fn an_output_in_space_is_measured_along_its_direction() {
    let line = "[SOL]\nw = {}\n[MAS]\na = { m = \"1 g\", dx0 = \"1 mm\" }\n[RES]\nk = { between = [\"w\", \"a\"], k = \"8 kN/m\" }\n\
                [SOX]\nout = { from = \"a\" }\n";
    let space = |outputs: &str| {
        format!(
            "[room]\ndim = 3\n[room.SOL]\nw = {{}}\n[room.MAS]\na = {{ m = \"1 g\", dx0 = [\"1 mm\", 0, \"1 mm\"] }}\n\
             [RES]\nk = {{ between = [\"room.w\", \"room.a\"], along = \"x\", k = \"8 kN/m\" }}\n\
             across = {{ between = [\"room.w\", \"room.a\"], along = \"z\", k = \"900 kN/m\" }}\n[SOX]\n{outputs}"
        )
    };
    let x = "x = { from = \"room.a\", along = \"x\" }\n";
    let z = "z = { from = \"room.a\", along = \"z\" }\n";
    let short = ["--seconds", "0.05", "--times", "1,2"];
    let (plain, along) = (measured(line, &short), measured(&space(x), &short));
    let (both, across) = (measured(&space(&format!("{x}{z}")), &short), measured(&space(z), &short));
    // 8 kN/m on 1 g: (ωT)²/24 rad per rad, over 141 rad
    assert!((5e-3..5e-2).contains(&error(&plain, "as written", 1)), "{plain:#}");
    for times in [1, 2] {
        let e = |found: &Json| error(found, "as written", times);
        let known = along["reference"]["known"].as_f64().expect("known");
        assert!((e(&along) - e(&plain)).abs() < known + 1e-9, "{} and {}", e(&along), e(&plain));
        // each output by itself; for two outputs, the larger error
        assert!(e(&across) > 50.0 * e(&along), "{} and {}", e(&across), e(&along));
        assert!((e(&both) / e(&across) - 1.0).abs() < 1e-6, "{} and {}", e(&both), e(&across));
    }
    // a probed position counts as a whole: its error is a distance, at most the error of its worst axis
    let body = measured(&space(x), &[&short[..], &["--probe", "room.a"]].concat());
    let (e, all) = (error(&body, "as written", 1), [&along, &across].map(|f| error(f, "as written", 1)));
    let mean = (all.iter().map(|e| e * e).sum::<f64>() / 2.0).sqrt();
    assert!((e / mean - 1.0).abs() < 0.05, "{e} and {mean}");
}

/// Covers outputs of several modules, oblique directions, and two outputs on one channel.
#[test]
fn what_an_output_hears_is_what_is_measured() {
    let text = |outputs: &str| CHAIN.split("[SOX]").next().map(|c| format!("{c}[SOX]\n{outputs}")).expect("a chain");
    let short = ["--seconds", "0.02", "--times", "1"];
    let of = |outputs: &str| error(&measured(&text(outputs), &short), "as written", 1);
    let (a, b) = (of("out = { from = \"a\" }\n"), of("out = { from = \"b\" }\n"));
    let two = of("a = { from = \"a\", gain = 3 }\nb = { from = \"b\", gain = 0.5 }\n"
        .replace("a = {", "one = {")
        .replace("\nb = {", "\ntwo = {")
        .as_str());
    assert!((two / a.max(b) - 1.0).abs() < 1e-9, "{two}, {a} and {b}");
    // two outputs on one channel are measured separately
    let mixed = of("one = { from = \"a\", channel = 0 }\ntwo = { from = \"b\", channel = 0 }\n");
    assert!((mixed / a.max(b) - 1.0).abs() < 1e-9, "{mixed}, {a} and {b}");
    // outputs on separate channels are compared with separate references
    let string = "[STRING]\ns = { n = 5, m = \"1 g\", f = \"2 kHz\" }\n[MAS]\nh = { m = \"1 g\", dx0 = \"1 mm\" }\n\
                  [RES]\nk = { between = [\"h\", \"s[1]\"], k = \"2 kN/m\" }\n[SOX]\n";
    let of = |outputs: &str| error(&measured(&format!("{string}{outputs}"), &short), "as written", 1);
    let each: Vec<f64> = (0..5).map(|i| of(&format!("out = {{ from = \"s[{i}]\" }}\n"))).collect();
    let all = of("out = { from = \"s[*]\" }\n");
    let worst = each.iter().copied().fold(0.0, f64::max);
    assert!((all / worst - 1.0).abs() < 1e-6, "{all}, {each:?}");
}

#[test]
fn the_page_has_a_plot_and_the_table() {
    let sandbox = Sandbox::new();
    let short = ["accuracy", "glass", "--seconds", "0.3", "--times", "1,2", "--reference", "8", "-o", "glass.html"];
    let text = sandbox.ca(&short).is(0).out;
    let page = fs::read_to_string(sandbox.path("glass.html")).expect("a page");
    for word in ["error", "ns/sample", "as written", "stability"] {
        assert!(text.contains(word) && page.contains(word), "{word}\n{text}");
    }
    assert!(text.contains("at 48000 Hz, against ") && page.contains("Error against run time"));
}

#[test]
fn nothing_to_hear_is_a_failure() {
    let sandbox = Sandbox::new();
    sandbox.put("mute.ca.toml", "[MAS]\na = { m = 1 }\n");
    sandbox.ca(&["accuracy", "mute.ca.toml"]).is(1).says(&["--probe"]);
    sandbox.put("still.ca.toml", "[MAS]\na = { m = 1 }\n[SOX]\nout = { from = \"a\" }\n");
    sandbox.ca(&["accuracy", "still.ca.toml", "--seconds", "0.01"]).is(1).says(&["no motion of `out`", "--seconds"]);
    sandbox.ca(&["accuracy", "glass", "--error", "0"]).is(2).says(&["above 0"]);
}

/// A row is not recommended if the uncertainty of the reference exceeds the limit, however small its error seems.
#[test]
fn no_way_is_better_than_its_reference_is_known() {
    let sandbox = Sandbox::new();
    let text = format!("{CHAIN}[CUB]\nhard = {{ between = [\"l\", \"b\"], k3 = \"10 GN/m^3\" }}\n");
    sandbox.put("hard.ca.toml", &text);
    let short = ["accuracy", "hard.ca.toml", "--seconds", "0.02", "--times", "1", "--reference", "4"];
    let ask = |error: &str, more: &[&str]| sandbox.ca(&[&short[..], &["--error", error], more].concat());
    let plain = ask("1e-30", &[]).is(3);
    assert!(
        plain.out.contains("the reference is accurate only to") && plain.out.contains("`--reference`"),
        "{}",
        plain.out
    );
    assert!(!plain.out.contains("fastest with"), "{}", plain.out);
    for error in ["1e-30", "1e-6"] {
        let found: Json = serde_json::from_str(&ask(error, &["--json"]).is(3).out).expect("JSON");
        assert!(found["reference"]["known"].as_f64().is_some_and(|k| k > 1e-6), "{found:#}");
        assert!(found["recommended"].is_null(), "{found:#}");
        assert!(found["verdict"].as_str().is_some_and(|v| v.contains("`--reference`")), "{found:#}");
    }
    sandbox.put("line.ca.toml", CHAIN);
    let r = sandbox.ca(&["accuracy", "line.ca.toml", "--seconds", "0.02", "--times", "1", "--error", "1e-30"]).is(3);
    assert!(r.out.contains("the closed form is accurate only to 1.0e-12"), "{}", r.out);
}

#[test]
fn no_reference_is_beyond_all_rates() {
    let sandbox = Sandbox::new();
    sandbox.put("model.ca.toml", CHAIN);
    sandbox.ca(&["accuracy", "model.ca.toml", "--reference", "256"]).is(2).says(&["at most 208 times the rate"]);
}

/// The model in single precision agrees to its rounding at every multiple of the rate. Models that do not fit in single
/// precision are reported.
#[test]
fn single_precision_is_a_way() {
    let found = measured(CHAIN, &["--seconds", "0.05", "--times", "1,4"]);
    for times in [1, 4] {
        let apart = error(&found, "single", times) - error(&found, "as written", times);
        assert!(apart != 0.0 && apart.abs() < 2e-4, "{apart:e} at x{times}");
    }
    let bowed = "[CEL]\nbar = { m = \"1 g\", f = \"220 Hz\", t60 = \"0.5 s\" }\n[ENX]\nbow = {}\n[REF]\nrub = { between = [\"bar\", \"bow\"], k = 1e3, z = 0.1 }\n[SOX]\nout = { from = \"bar\" }\n[gesture]\nbow = [[0, 0], [0.05, \"1 mm\"]]\n";
    let found = measured(bowed, &["--seconds", "0.05", "--times", "1"]);
    assert!((error(&found, "single", 1) / error(&found, "as written", 1) - 1.0).abs() < 1e-2, "{found:#}");
    let body = "[room]\ndim = 3\n[room.TETRA]\np = { edge = \"2 cm\", m = \"1 g\", k = \"8 kN/m\", spin = [\"3 Hz\", 0, 0] }\n[SOF]\nout = { from = \"room.p.link[0]\" }\n";
    let kinds = ca_lab::catalog();
    let lpr = kinds.iter().find(|k| k.code.starts_with("LPR")).expect("a quadripole");
    for (text, reason) in [(body, "a distance in space"), (lpr.example, "a distance in space")] {
        let found = measured(text, &["--seconds", "0.01", "--times", "1", "--reference", "4"]);
        let why = found["refused"].as_array().expect("a list").iter().find(|r| r["method"] == "single");
        assert!(why.is_some_and(|r| r["why"].as_str().is_some_and(|w| w.contains(reason))), "{found:#}");
    }
}

/// `docs/measured/accuracy.md` matches the command for short scenes, except for the times.
#[test]
fn the_page_of_error_against_run_time_is_true() {
    use ca_benches::accuracy::{CASES, page::rows};
    let page = include_str!("../../../../../docs/measured/accuracy.md");
    for (case, reference) in [(&CASES[0], "8"), (&CASES[3], CASES[3].reference)] {
        let found = measured(&(case.text)(), &["--seconds", case.seconds, "--times", "1", "--reference", reference]);
        let reported = rows(page, case.title);
        for r in found["rows"].as_array().expect("rows") {
            let name = format!("{} ×1", r["method"].as_str().expect("a method"));
            let row = reported.iter().find(|t| t[0].trim_end_matches(" *") == name).unwrap_or_else(|| panic!("{name}"));
            let said = |cell: usize| row[cell].trim_start_matches("< ").parse::<f64>().expect("a number");
            let error =
                r["error"].as_f64().expect("an error").max(found["reference"]["known"].as_f64().expect("known"));
            assert!((error / said(1) - 1.0).abs() < 0.06, "{name}: {error:e} and {row:?}");
            assert!((r["cents"].as_f64().expect("a pitch") - said(3)).abs() < 0.002, "{name}: {r} and {row:?}");
            assert_eq!(row[8], r["stability"].as_str().expect("a word"), "{name}");
        }
    }
}

/// `--error` plays a model by another method, and writes it.
#[test]
fn a_render_meets_an_error_by_the_cheapest_proven_method() {
    let sandbox = Sandbox::new();
    sandbox.put(
        "own.ca.toml",
        "# kept\n[SOL]\nwall = {}\n[MAS]\nbob = { m = \"1 g\", x = \"1 mm\", v = \"-1 m/s\" }\n\
         [BUT]\nhit = { between = [\"wall\", \"bob\"], k = \"40 kN/m\" }\n[SOX]\nout = { from = \"bob\" }\n",
    );
    let render =
        |more: &[&str]| sandbox.ca(&[&["render", "own.ca.toml", "--seconds", "0.02", "-o", "out.wav"], more].concat());
    let ran = render(&["--error", "0.01", "--write", "chosen.ca.toml"]).is(0);
    assert!(ran.err.contains("error") && ran.err.contains("per sample") && ran.err.contains("proven"), "{}", ran.err);
    let chosen = fs::read_to_string(sandbox.path("chosen.ca.toml")).unwrap();
    assert!(chosen.starts_with("# kept\n") && chosen.contains("method"), "{chosen}");
    // the written model is computed as the render was
    let by_error = fs::read(sandbox.path("out.wav")).unwrap();
    sandbox.ca(&["render", "chosen.ca.toml", "--seconds", "0.02", "-o", "again.wav", "-q"]).is(0);
    assert!(by_error == fs::read(sandbox.path("again.wav")).unwrap());
    let ran = sandbox.ca(&["check", "chosen.ca.toml"]).is(0);
    assert!(ran.out.contains("proven"), "{}", ran.out);

    render(&["--error", "1e-30"]).is(1).says(&["no method that is proven has an error of at most 1e-30"]);
    // outputs are checked before the model is measured, and a model from standard input is read once
    sandbox.ca(&["render", "own.ca.toml", "--error", "0.01", "-o", "out.txt"]).is(2);
    sandbox.sh("cat own.ca.toml | ca render - --error 0.01 --seconds 0.02 -o piped.wav -q").is(0);
    // the choice depends on measured times, so another run may choose another method
    assert_eq!(by_error.len(), fs::read(sandbox.path("piped.wav")).unwrap().len());
    render(&["--error", "0"]).is(2);
    render(&["--write", "other.ca.toml"]).is(2);
    render(&["--error", "0.01", "--write", "chosen.ca.toml"])
        .is(1)
        .says(&["`chosen.ca.toml` exists; choose another name"]);
}
