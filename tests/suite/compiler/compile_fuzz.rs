//! The compiler answers any input with a scene or with findings, in little time and memory.

use ca_compile::{Options, load};
use ca_core::tick;
use ca_import::mims;
use ca_model::{Entry, Model, Value, render};
use ca_tests::catalog;
use proptest::prelude::*;

fn examples() -> Vec<&'static str> {
    catalog().iter().map(|k| k.example).collect()
}

/// Loads a text, checks its findings and plays the scene for a few ticks.
fn survives(text: &str) -> Vec<&'static str> {
    let (model, result) = load(text, "m.ca.toml", &catalog(), &Options::default());
    let diags = match result {
        Ok(scene) => {
            assert!(!scene.findings.has_errors(), "{text}\n{}", scene.findings);
            let mut state = scene.state();
            if scene.counts.n_mat < 1000 {
                (0..3).for_each(|_| tick(&scene, &mut state));
            }
            scene.findings
        }
        Err(diags) => {
            assert!(diags.has_errors(), "no scene and no reason:\n{text}");
            diags
        }
    };
    for d in &diags.list {
        for (span, _) in &d.labels {
            assert!(!span.is_some() || span.start <= span.end && span.end <= text.len(), "{text}\n{d:?}");
            assert!(!span.is_some() || text.is_char_boundary(span.start) && text.is_char_boundary(span.end), "{d:?}");
        }
    }
    render::text(&diags, &model, false);
    diags.list.iter().map(|d| d.code).collect()
}

#[test]
fn examples_compile_without_errors() {
    for text in examples() {
        let codes = survives(text);
        assert!(codes.iter().all(|c| c.starts_with('W')), "{text}\n{codes:?}");
    }
}

#[test]
fn absurd_models_are_answered() {
    let cases: &[(&str, &str)] = &[
        ("", "E024"),
        ("# only a comment\n", "E024"),
        ("[MAS]\n", "E024"),
        ("[MAS]\na = { m = 1e308, dx0 = 1e308 }\n[SOX]\no = { from = 'a' }", ""),
        ("[MAS]\na = { m = 5e-324 }\n[SOX]\no = { from = 'a' }", "E009"),
        ("[STRING]\ns = { n = 1000000000, k = 1, m = 1 }", "E009"),
        ("[STRING]\ns = { n = -1, k = 1, m = 1 }", "E009"),
        ("[STRING]\ns = { n = nan, k = 1, m = 1 }", "E009"),
        ("[MESH]\ns = { nx = 4096, ny = 4096, k = 1, m = 1 }", "E027"),
        ("[MESH]\ns = { nx = 577, ny = 578, k = 1, m = 1 }", "E027"),
        (
            "[STRING]\ns = { n = 9000, k = 1, m = 1 }\n[RES]\nr = { between = ['s[*]', 's[*]'], pairs = 'all', k = 1 }",
            "E027",
        ),
        ("[rate]\nsound = 0", "E009"),
        ("[rate]\nsound = nan\ngesture = 3", "E009"),
        ("[rate]\nsound = 'fast'", "E013"),
        ("[model]\nseconds = -1", "E009"),
        ("[model]\nunits = 3", "E011"),
        ("[model]\nunits = 'alg'\nreference_rate = 0", "E009"),
        ("[param]\na = 'b'\nb = 'a'", "E006"),
        ("[param]\nx = { value = 3, live = true }\n[MAS]\na = { m = 'x' }\nx = { m = 1 }", "E012"),
        ("[HRZ]\nh = { between = ['a', 'b'], k = 1, p = [1] }", "E006"),
        ("[HRZ]\nh = { between = ['a', 'b'], k = 1, p = '1.3' }", "E009"),
        ("[MAS]\na = { m = 1 }\n[ENF]\nf = { to = 'f' }", "E017"),
        ("[MAS]\na = { m = 1 }\n[SOX]\no = { from = 'o' }", "E017"),
        ("[MAS]\na = { m = 1 }\n[SOX]\no = { from = 'a', channel = 256 }", "E009"),
        ("[MAS]\na = { m = 1 }\n[RES]\nr = { between = [['a'], ['a']], pairs = 'all', k = 1 }", "E018"),
        ("[MAS]\na = { m = 1 }\n[RES]\nr = { between = [[], 'a'], k = 1 }", "E018"),
        ("[CHAIN]\nc = { n = 2, k = 1, m = 1 }\n[SOX]\no = { from = 'c@0.5', gain = 1e308 }", ""),
        ("[ENX]\np = {}\n[CHAIN]\nc = { n = 2, k = 1, m = 1 }\n[SOX]\no = { from = 'c@p' }", ""),
        ("[BANK]\nb = { f = [], m = 1 }", "E006"),
        ("[WAVEGUIDE]\nw = { f = 1e-300, z = 1, at = 0.5 }", "E023"),
        ("[WAVEGUIDE]\nw = { f = 1e300, z = 1, at = 0.5 }", "E023"),
        ("[WAVEGUIDE]\nw = { f = 440, z = 1e308, at = 0.5 }\n[SOX]\no = { from = 'w[0]' }", "E009"),
        ("[WAVEGUIDE]\nw = { f = 440, z = 1, at = [] }", "E006"),
        ("[WAVEGUIDE]\nw = { f = 440, z = 1, t60 = 1e-300, at = 0.5 }", "E023"),
        (
            "[WAVEGUIDE]\nw = { f = 440, z = 1, t60 = 1e300, t60_high = 1e-300, at = 0.5 }\n[SOX]\no = { from = 'w[0]' }",
            "W114",
        ),
        ("[WAVEGUIDE]\nw = { f = 440, z = 1e-300, m = 1e300, at = 0.5 }", "E023"),
        ("[BUT]\nb = { between = ['a', 'b'], k = 1, l0 = 1 }", "E004"),
        ("[equivalence]\nmass = ['20 g', '20 g']\n[CEL]\nb = { m = '1 g', f = 440 }\n[SOX]\no = { from = 'b' }", ""),
    ];
    for (text, code) in cases {
        let codes = survives(text);
        assert!(code.is_empty() || codes.contains(code), "{text}\n{codes:?}");
    }
}

#[test]
fn many_outputs_make_one_finding() {
    use std::fmt::Write as _;
    let mut text = String::from("[MAS]\na = { m = 1 }\n[SOX]\n");
    (0..300).for_each(|i| writeln!(text, "o{i} = {{ from = 'a' }}").expect("a string grows"));
    assert_eq!(survives(&text), ["E027"]);
}

/// A live pitch on a long string computes its corner values once, not per mass.
#[test]
fn a_long_live_string_compiles() {
    let text = "[param]\nf = { value = 2, live = true, min = 1, max = 20000 }\n[STRING]\ns = { n = 5000, f = 'f', m = 1 }\n\
                [SOX]\no = { from = 's[0]' }";
    assert!(survives(text).iter().all(|c| c.starts_with('W')));
}

#[test]
fn rates_asked_for_are_checked() {
    let text = "[CEL]\nb = { m = '1 g', f = 440 }\n[SOX]\no = { from = 'b' }\n[rate]\ngesture = '3 kHz'";
    for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 44_100.0, 2000.0] {
        let options = Options { rate: Some(rate), ..Options::default() };
        let found = load(text, "", &catalog(), &options).1.expect_err("does not fit");
        assert_eq!(found.list.iter().map(|d| d.code).collect::<Vec<_>>(), ["E020"], "{rate}");
    }
    let options = Options { probes: vec!["nobody".into(), "b[7]".into()], ..Options::default() };
    assert_eq!(load(text, "", &catalog(), &options).1.expect_err("no such probes").list.len(), 2);
}

#[test]
fn imported_models_compile() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("mims");
    for file in std::fs::read_dir(folder).expect("tests/mims is there") {
        let path = file.expect("readable").path();
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        let (model, diags) = mims::import(&text, "m.mdl");
        if path.extension().is_some_and(|e| e == "mdl") && !diags.has_errors() {
            let made = ca_compile::compile(&model, &catalog(), &Options::default());
            assert!(made.is_ok(), "{}: {}", path.display(), made.expect_err("seen"));
        }
    }
}

fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("0".into()),
        Just("-1".into()),
        Just("nan".into()),
        Just("1e300".into()),
        Just("\"\"".into()),
        Just("\"µ\"".into()),
        Just("[[0, 0], [1, 1]]".into()),
        Just("\"low[-41]\"".into()),
        Just("{ a = 1 }".into()),
        Just("true".into()),
        any::<i16>().prop_map(|v| v.to_string()),
        "\"[-0-9.]{1,4} ?[kmuµ]?[gmsNHz/^ ]{0,5}\"",
        "\"[a-z@\\[\\]*0-9.,é]{0,8}\"",
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn a_value_replaced(which in 0usize..64, at in prop::collection::vec((0usize..40, number()), 1..4)) {
        let all = examples();
        let mut text = String::from(all[which % all.len()]);
        for (n, new) in at {
            let places: Vec<usize> = text.match_indices("= ").map(|m| m.0 + 2).collect();
            let start = places[n % places.len()];
            let end = text[start..].find([',', '}', '\n']).map_or(text.len(), |i| start + i);
            text.replace_range(start..end, &new);
        }
        survives(&text);
    }

    #[test]
    fn lines_mixed(a in 0usize..64, b in 0usize..64, keep in any::<u64>()) {
        let all = examples();
        let lines = all[a % all.len()].lines().chain(all[b % all.len()].lines());
        let text: Vec<&str> = lines.enumerate().filter(|(i, _)| keep >> (i % 64) & 1 == 1).map(|l| l.1).collect();
        survives(&text.join("\n"));
    }

    /// A model built by a program, without text to point at.
    #[test]
    fn a_model_that_was_built(items in prop::collection::vec((0usize..30, "[ab]", 0usize..12, number()), 0..6)) {
        let catalog = ca_tests::catalog();
        let kinds: Vec<_> = catalog.iter().collect();
        let mut model = Model::default();
        for (kind, name, arg, text) in items {
            let kind = kinds[kind % kinds.len()];
            let key = kind.params[arg % kind.params.len()].name;
            let args = [Entry::new("between", Value::from(vec!["a", "b"])), Entry::new(key, text)];
            model.add(kind.code, &name, args);
        }
        if let Err(diags) = ca_compile::compile(&model, &catalog, &Options::default()) {
            prop_assert!(diags.has_errors());
            render::text(&diags, &model, false);
        }
    }
}
