//! Import of MIMS models: `tests/mims/*.mdl` are our models in the older dialect of the scripter. `*.txt` beside each
//! has the imported model and its findings (`UPDATE=1` rewrites them; read the diff).
//!
//! That generators equal what they replace is computed, not read off: the text and the imported model are simulated
//! side by side, by separate short programs, and every mass must move alike.

use ca_import::mims::import;
use ca_model::diag::{Diags, Severity};
use ca_model::{Entry, Model, Value};
use ca_tests::skipped::skipped;
use proptest::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

mod foreign;
mod independent_parser;
use independent_parser::same_movement;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("mims")
}

fn value(v: &Value) -> String {
    match v {
        Value::Num(x) => format!("{x}"),
        Value::Text(t) => format!("{t:?}"),
        Value::Bool(b) => format!("{b}"),
        Value::List(l) => format!("[{}]", l.iter().map(|e| value(&e.value)).collect::<Vec<_>>().join(", ")),
        Value::Table(t) => format!("{{ {} }}", table(t)),
    }
}

fn table(entries: &[Entry]) -> String {
    entries.iter().map(|e| format!("{} = {}", e.key, value(&e.value))).collect::<Vec<_>>().join(", ")
}

/// The content of a model and its findings, line by line.
fn shown(model: &Model, diags: &Diags, text: &str) -> String {
    let mut out = String::new();
    for line in model.header.lines() {
        _ = writeln!(out, "# {line}");
    }
    for (name, entries) in [("model", &model.meta), ("rate", &model.rate), ("param", &model.params)] {
        for e in entries {
            _ = writeln!(out, "[{name}] {} = {}", e.key, value(&e.value));
        }
    }
    for g in &model.groups {
        _ = writeln!(out, "[{}] {}", g.name, table(&g.props));
    }
    for i in &model.items {
        let group = i.group.map_or(String::new(), |g| format!("({}) ", model.groups[g].name));
        _ = writeln!(out, "{group}{} {} {{ {} }}", i.kind, i.name, table(&i.args));
    }
    for d in &diags.list {
        let span = d.span();
        let place = if span.is_some() {
            let row = text[..span.start].matches('\n').count() + 1;
            format!(" line {row} `{}`: {}", &text[span.start..span.end], d.labels[0].1)
        } else {
            String::new()
        };
        _ = writeln!(out, "{} {}{place}", d.code, d.title);
        if let Some(help) = &d.help {
            _ = writeln!(out, "  help: {help}");
        }
        if let Some(fix) = &d.fix {
            _ = writeln!(out, "  fix: `{}`", fix.text);
        }
    }
    out
}

fn models() -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = std::fs::read_dir(folder()).unwrap().map(|f| f.unwrap().path()).collect();
    all.retain(|p| p.extension().is_some_and(|e| e == "mdl"));
    all.sort();
    all
}

#[test]
fn models_of_our_own_become_what_stands_beside_them() {
    let mut wrong = Vec::new();
    for path in models() {
        let text = std::fs::read_to_string(&path).unwrap();
        let (model, diags) = import(&text, path.to_str().unwrap());
        let got = shown(&model, &diags, &text);
        let beside = path.with_extension("txt");
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&beside, &got).unwrap();
        } else if std::fs::read_to_string(&beside).unwrap_or_default() != got {
            wrong.push(format!("{}:\n{got}", path.display()));
        }
    }
    assert!(models().len() > 8, "the models are missing");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_type_is_among_the_laws() {
    let text = std::fs::read_to_string(folder().join("laws.mdl")).unwrap();
    let types: Vec<&str> = text.lines().filter_map(|l| l.split_whitespace().nth(1)).collect();
    let all = "param audioParam mass massG osc ground posInput spring springDamper damper nlSpring nlSpring2 nlSpring3 \
               contact detent nlPluck nlBow frcInput posOutput frcOutput";
    for ty in all.split_whitespace() {
        assert!(types.contains(&ty), "`{ty}` is in no model");
    }
}

/// The polygons of mi.lib against ours, from the numbers in `laws.mdl`.
#[test]
fn pluck_and_bow_keep_their_curves() {
    let text = std::fs::read_to_string(folder().join("laws.mdl")).unwrap();
    let (model, _) = import(&text, "laws.mdl");
    let num = |item: &str, key: &str| {
        let item = model.items.iter().find(|i| i.name == item).unwrap();
        match item.args.iter().find(|e| e.key == key).map(|e| &e.value) {
            Some(Value::Num(x)) => *x,
            other => panic!("{item:?} {key} {other:?}"),
        }
    };
    let (k, scale) = (0.2, 0.1);
    let pluck = model.items.iter().find(|i| i.name == "l11").unwrap();
    let points = match pluck.args.iter().find(|e| e.key == "spring").map(|e| &e.value) {
        Some(Value::List(points)) => points.iter().map(|p| match &p.value {
            Value::List(p) => [0, 1].map(|k| if let Value::Num(x) = p[k].value { x } else { f64::NAN }),
            other => panic!("{other:?}"),
        }),
        other => panic!("{other:?}"),
    };
    let points: Vec<[f64; 2]> = points.collect();
    let (z, v) = (0.9, 0.27);
    let (f, v0, v1, fd) = (num("l13", "f"), num("l13", "v0"), num("l13", "v1"), num("l13", "fd"));
    for i in 0..=400 {
        let e = 0.0003 * f64::from(i);
        // it repels
        let theirs = -if e < scale / 10.0 {
            (k - k / 10.0) * e
        } else if e < scale {
            scale / 10.0 * k - k / 10.0 * e
        } else {
            0.0
        };
        let ours = ca_tests::follow(&points, e);
        assert!((theirs - ours).abs() < 1e-15, "pluck at {e}: {theirs} {ours}");
        let w = 0.001 * f64::from(i);
        let theirs = if w < v / 3.0 {
            (z - z / 3.0) * w
        } else if w < v {
            v / 3.0 * z - z / 3.0 * w
        } else {
            0.0
        };
        let ours = if w <= v0 {
            f * w / v0
        } else if w < v1 {
            f + (fd - f) * (w - v0) / (v1 - v0)
        } else {
            fd
        };
        assert!((theirs - ours).abs() < 1e-15, "bow at {w}: {theirs} {ours}");
    }
}

#[test]
fn published_models_are_read() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/mims");
    if !dir.is_dir() {
        skipped("published models", "no shared/data/mims beside the project");
        return;
    }
    let generators = [
        ("1000massString", "STRING str 1000, 0 REF"),
        ("20x30mesh", "MESH mesh 20, 0 REF"),
        ("BowedString", "STRING low 150, 0 REF"),
        ("IPlayTheTriangle", "4 REF"),
        ("Resonator", "CHAIN str 30, 2 REF"),
    ];
    for (name, expected) in generators {
        let path = dir.join(format!("{name}.mdl"));
        let text = std::fs::read_to_string(&path).unwrap();
        let (model, diags) = import(&text, path.to_str().unwrap());
        assert!(diags.list.iter().all(|d| d.severity == Severity::Note), "{name}: {diags}");
        let size = |i: &ca_model::Item| match &i.args[0].value {
            Value::Num(n) => format!("{} {} {n}", i.kind, i.name),
            _ => String::new(),
        };
        let made = model.items.iter().filter(|i| matches!(i.kind.as_str(), "STRING" | "CHAIN" | "MESH"));
        let mut got: Vec<String> = made.map(size).collect();
        got.push(format!("{} REF", model.items.iter().filter(|i| i.kind == "REF").count()));
        assert_eq!(got.join(", "), expected, "{name}");
        let replaced = format!("@probe frcInput {}", text.split_whitespace().find(|w| w.contains("_m")).unwrap());
        same_movement(&format!("{text}\n{}", replaced.replace("springDamperDamper", "springDamper")));
    }
}

#[test]
fn models_of_our_own_move_as_written() {
    for (name, first) in [("string", "@gut_m1"), ("chains", "@one_1"), ("meshes", "@rag_m1_1")] {
        let text = std::fs::read_to_string(folder().join(name).with_extension("mdl")).unwrap();
        same_movement(&format!("{text}@probe frcInput {first}"));
    }
}

/// Rows and lattices with faults: a grid of masses and grounds, with links missing, doubled, changed or added.
fn faulty() -> impl Strategy<Value = String> {
    let node = prop_oneof![12 => Just('m'), 1 => Just('g'), 1 => Just('h')];
    let link =
        prop_oneof![20 => Just('s'), 1 => Just('-'), 1 => Just('2'), 1 => Just('k'), 1 => Just('r'), 1 => Just('z')];
    let nodes = prop::collection::vec(node, 64);
    let links = prop::collection::vec(link, 128);
    let extra = prop::collection::vec((0usize..64, 0usize..64), 0..3);
    let shape = prop_oneof![Just((1usize, 12usize)), Just((4, 5)), Just((6, 4)), Just((2, 9))];
    (shape, nodes, links, extra, any::<bool>(), 0usize..64, 0u8..4).prop_map(
        |((nx, ny), nodes, links, extra, turned, push, border)| {
            let mut text = String::from("@K param 0.1\n");
            let label = |i: usize, j: usize| if turned { format!("@n{j}_{i}") } else { format!("@n{i}_{j}") };
            for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
                let (ei, ej) = (i == 0 || i + 1 == nx, j == 0 || j + 1 == ny);
                let fixed = match border {
                    1 => ei || ej,
                    2 => ei && ej,
                    _ => false,
                };
                let kind = match nodes[i * ny + j] {
                    _ if fixed => "ground 0",
                    'g' => "ground 0",
                    'h' => "mass 2 0 0",
                    _ => "mass 1 0 0",
                };
                _ = writeln!(text, "{} {kind}", label(i, j));
            }
            let mut say = |a: (usize, usize), b: (usize, usize), how: char| {
                let (a, b) = (label(a.0, a.1), label(b.0, b.1));
                _ = match how {
                    '-' => Ok(()),
                    '2' => writeln!(text, "@r spring {a} {b} K 0.01\n@r spring {b} {a} K 0.01"),
                    'z' => writeln!(text, "@r spring {a} {b} K 0.02"),
                    'k' => writeln!(text, "@r spring {a} {b} 0.2 0.01"),
                    'r' => writeln!(text, "@r springDamper {b} {a} K 0.01"),
                    _ => writeln!(text, "@r spring {a} {b} K 0.01"),
                };
            };
            for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
                let n = 2 * (i * ny + j);
                if i + 1 < nx {
                    say((i, j), (i + 1, j), links[n]);
                }
                if j + 1 < ny {
                    say((i, j), (i, j + 1), links[n + 1]);
                }
            }
            let place = |p: usize| ((p % (nx * ny)) / ny, p % ny);
            for (a, b) in extra {
                if place(a) != place(b) {
                    say(place(a), place(b), 's');
                }
            }
            let at = place(push);
            _ = writeln!(text, "@f frcInput {}", label(at.0, at.1));
            text
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 600, ..ProptestConfig::default() })]

    #[test]
    fn generators_move_as_what_they_replace(text in faulty()) {
        // a push on a ground moves nothing and is left out
        let pushed = text.trim_end().rsplit(' ').next().unwrap();
        let fixed = text.lines().any(|l| l.starts_with(&format!("{pushed} ground")));
        same_movement(if fixed { text.rsplit_once("@f ").unwrap().0 } else { &text });
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let text = String::from_utf8_lossy(&bytes);
        let (model, diags) = import(&text, &text);
        prop_assert!(!diags.has_errors() || model.items.is_empty());
    }

    #[test]
    fn arbitrary_lines_never_panic(lines in prop::collection::vec(line(), 0..40)) {
        let text = lines.join("\n");
        let (model, diags) = import(&text, "x.mdl");
        shown(&model, &diags, &text);
    }
}

/// A nearly valid line.
fn line() -> impl Strategy<Value = String> {
    let label = prop_oneof![8 => "@[abm][0-9]?(_[0-9])?", 1 => "@?\\PC{0,4}"];
    let ty = prop_oneof![
        8 => prop::sample::select(vec!["mass", "massG", "osc", "ground", "posInput", "spring", "springDamper", "damper",
            "nlSpring", "nlSpring2", "nlSpring3", "contact", "detent", "nlPluck", "nlBow", "frcInput", "posOutput",
            "frcOutput", "param", "audioParam", "springDamperDamper", "NLbow"]).prop_map(String::from),
        1 => "\\PC{0,6}",
    ];
    let arg = prop_oneof![
        4 => "@[abm][0-9]?(_[0-9])?",
        4 => "-?[0-9]{1,2}\\.?[0-9]?(e-?[0-9]{1,3})?",
        1 => "[abm][0-9]",
        1 => "\\PC{0,5}",
    ];
    (label, ty, prop::collection::vec(arg, 0..6)).prop_map(|(l, t, a)| format!("{l} {t} {}", a.join(" ")))
}
