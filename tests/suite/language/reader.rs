//! The reader: content of models, spans, and robustness.

use ca_model::diag::{Diag, Diags, Severity};
use ca_model::{Entry, Model, Span, Value, read, render, schema};
use ca_tests::catalog;
use proptest::prelude::*;

fn read(text: &str) -> (Model, Diags) {
    read::read(text, "m.ca.toml", &catalog())
}

fn clean(text: &str) -> Model {
    let (model, diags) = read(text);
    assert!(diags.list.is_empty(), "{}", render::text(&diags, &model, false));
    model
}

/// Reads a text that is valid only in TOML 1.1.
fn newer(text: &str) -> Model {
    let (model, diags) = read(text);
    let codes: Vec<&str> = diags.list.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["N205"], "{}", render::text(&diags, &model, false));
    model
}

fn codes(text: &str) -> Vec<&'static str> {
    read(text).1.list.iter().map(|d| d.code).collect()
}

const FULL: &str = r#"# A bell.
#
#   play it softly

# not the header
[model]
title = "Bell"
units = "si"

[rate]
sound = "48 kHz"
gesture = "3 kHz"

[param]
z = { value = 1.0, unit = "N s/m", live = true, min = 0, max = 5 }
q = 3

[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = 2 }

[MAS.hammer]
m = 0x10
x = -inf

[ball]
gravity = [0, 0, "-9.81 m/s^2"]
dim = 3

[ball.MAS]
b.m = "1 g"
a = { m = "1 g", v = -0 }

[SOL]
wall = {}

[gesture]
hand = [[0, 0], [0.5, "1 mm"]]
ball.place = [[0, 1]]

[equivalence]
mass = ["20 g", "20 g"]
"#;

#[test]
fn a_full_model() {
    let m = clean(FULL);
    assert_eq!((m.header.as_str(), m.title(), m.file.as_str()), ("A bell.\n\n  play it softly", "Bell", "m.ca.toml"));
    let names: Vec<_> = m.items.iter().map(|i| (i.kind.as_str(), i.name.as_str(), i.group)).collect();
    let expected = [
        ("CEL", "bar", None),
        ("MAS", "hammer", None),
        ("MAS", "ball.b", Some(0)),
        ("MAS", "ball.a", Some(0)),
        ("SOL", "wall", None),
    ];
    assert_eq!(names, expected);
    let args = |i: usize| m.items[i].args.iter().map(|a| (a.key.as_str(), a.value.clone())).collect::<Vec<_>>();
    assert_eq!(args(0), [("m", "2 g".into()), ("f", "440 Hz".into()), ("t60", 2.0.into())]);
    assert_eq!(args(1), [("m", 16.0.into()), ("x", f64::NEG_INFINITY.into())]);
    assert!(matches!(args(3)[1].1, Value::Num(v) if v == 0.0 && v.is_sign_negative()));
    let keys = |list: &[Entry]| list.iter().map(|e| e.key.clone()).collect::<Vec<_>>();
    assert_eq!(keys(&m.params), ["z", "q"]);
    assert_eq!(keys(&m.gestures), ["hand", "ball.place"]);
    assert_eq!(keys(&m.groups[0].props), ["gravity", "dim"]);
    assert!(matches!(&m.groups[0].props[0].value, Value::List(l) if l.len() == 3));
    assert_eq!(keys(&m.equivalence), ["mass"]);
    let Value::Table(z) = &m.params[0].value else { panic!("{:?}", m.params[0]) };
    assert_eq!(keys(z), ["value", "unit", "live", "min", "max"]);
}

#[test]
fn spans_point_at_what_they_say() {
    let m = clean(FULL);
    let at = |s: Span| &FULL[s.start..s.end];
    for item in &m.items {
        assert_eq!(at(item.kind_span), item.kind);
        assert_eq!(at(item.name_span), item.name.rsplit('.').next().unwrap());
        for a in &item.args {
            assert_eq!(at(a.key_span), a.key);
        }
    }
    assert_eq!(at(m.items[0].span), r#"{ m = "2 g", f = "440 Hz", t60 = 2 }"#);
    assert_eq!(at(m.items[0].args[1].span), r#""440 Hz""#);
    assert_eq!(at(m.groups[0].span), "ball");
    // a byte order mark and CRLF line ends do not shift spans
    let other = format!("\u{feff}{}", FULL.replace('\n', "\r\n"));
    let m = clean(&other);
    let s = m.items[2].args[0].span;
    assert_eq!(&other[s.start..s.end], r#""1 g""#);
    assert_eq!(m.header, "A bell.\n\n  play it softly");
}

#[test]
fn all_errors_in_one_run() {
    let text = r#"
[modle]
title = "x"
[MAS]
a = { m = "1 g", mm = 2, zeta = 1 }
b = 3
my-mass = {}
[mas]
c = { m = 1 }
[SOL]
a = { when = 1979-05-27 }
[XYZZY]
d = {}
[rat]
sound = 3
"#;
    let (model, diags) = read(text);
    let list: Vec<&str> = diags.list.iter().map(|d| d.code).collect();
    assert_eq!(list, ["E002", "E004", "E004", "E003", "E014", "E002", "E012", "E006", "E002", "E002"]);
    // reading continues with the intended meaning
    assert_eq!(model.title(), "x");
    assert_eq!(model.rate.len(), 1);
    let names: Vec<_> = model.items.iter().map(|i| (i.kind.as_str(), i.name.as_str())).collect();
    assert_eq!(names, [("MAS", "a"), ("MAS", "b"), ("MAS", "c"), ("XYZZY", "d")]);
}

#[test]
fn a_missing_bracket_does_not_hide_the_rest_of_the_file() {
    let text = "[MAS]\na = { m = \"20 g }\nb = { m = 1\n[SOL\nc = {}\n[CEL]\nd = { m = [1, 2 }\ne = { q = 1 }\n";
    let (model, diags) = read(text);
    let names: Vec<_> = model.items.iter().map(|i| (i.kind.as_str(), i.name.as_str())).collect();
    assert_eq!(names, [("MAS", "a"), ("MAS", "b"), ("SOL", "c"), ("CEL", "d"), ("CEL", "e")]);
    assert_eq!(model.items[0].args[0].value, "20 g".into());
    assert_eq!(diags.list.iter().map(|d| d.code).collect::<Vec<_>>(), ["E001", "E001", "E001", "E001", "E004"]);
    let q = diags.list[4].span();
    assert_eq!(&text[q.start..q.end], "q");
    // the fixes of the first three make it valid TOML up to there
    let mut fixed = text.to_string();
    for d in diags.list[..3].iter().rev() {
        let fix = d.fix.as_ref().unwrap();
        fixed.replace_range(fix.span.start..fix.span.end, &fix.text);
    }
    assert!(!codes(fixed.split("[CEL]").next().unwrap()).contains(&"E001"), "{fixed}");
}

#[test]
fn lists_and_tables_may_run_over_lines() {
    let m = newer("[MAS]\na = {\n  m = 1, # one\n  x = \"2 m\"\n}\n[gesture]\nh = [\n [0, 0],\n [1, 1]\n ,\n]\n");
    assert_eq!((m.items.len(), m.items[0].args.len(), m.gestures.len()), (1, 2, 1));
    let (m, d) = read("[MAS]\na = {\n  m = 1, # one\n  x = \"2 m\"\n}\nb = { m = 20 g }\n");
    assert_eq!((m.items.len(), m.items[0].args.len(), d.list.len()), (2, 2, 1));
}

#[test]
fn rare_but_right_is_left_alone() {
    let text = r##"["MAS"] # a
"a" . m = 1
'b' = { m = [ [1], # x
 [2]
 ]
, x = """
[\""""""
 }
[ ball . SOL ]
c = {}
[model]
title = '''
x = {''y'''''
doc = "# [ { \\"
"##;
    let m = newer(text);
    assert_eq!((m.items.len(), m.title(), m.meta.len()), (3, "x = {''y''", 2));
}

#[test]
fn no_file_is_too_deep_or_too_long() {
    let bombs = [
        "[".repeat(100_000),
        format!("a={}", "[".repeat(100_000)),
        "a={".repeat(100_000),
        "a={b=1 [] ".repeat(100_000),
        "a={b=1 []\n".repeat(100_000),
        "[MAS]\na = { m = 1\n".repeat(30_000),
        "a={\n[b]\n".repeat(30_000),
        "[a] \"\"\"\n\"\"\" a={b=1 [] ".repeat(30_000),
        "a=[ x {".repeat(30_000),
        format!("[gesture]\n{}a = 1", "a.".repeat(100_000)),
        format!("[{}a]", "a.".repeat(100_000)),
        "a\n".repeat(100_000),
        "a = 1\n".repeat(50_000),
        "[MAS]\n".repeat(50_000),
        "a=\"".repeat(100_000),
    ];
    for text in bombs {
        let (model, diags) = read(&text);
        assert!(diags.has_errors() && !render::text(&diags, &model, false).is_empty());
    }
}

#[test]
fn numbers_as_written() {
    let value = |text: &str| match read(&format!("[MAS]\na = {{ m = {text} }}")).0.items[0].args.first() {
        Some(e) => e.value.clone(),
        None => Value::Bool(false),
    };
    for (text, v) in
        [("1_000", 1000.0), ("0b101", 5.0), ("0o17", 15.0), ("+7", 7.0), ("1e-3", 1e-3), ("99999999999999999999", 1e20)]
    {
        assert_eq!(value(text), Value::Num(v), "{text}");
    }
    assert!(matches!(value("nan"), Value::Num(v) if v.is_nan()));
    assert_eq!(codes("[MAS]\na = { m = 1e999 }"), ["E006"]);
}

#[test]
fn a_report_shows_twenty_and_counts_all() {
    let mut diags = Diags::new();
    for i in 0..30 {
        diags.push(Diag::warning("W106", format!("warning {i}")));
    }
    diags.push(Diag::error("E013", "the error").help("look here"));
    let text = render::text(&diags, &Model::default(), false);
    assert!(text.contains("error[E013]: the error") && text.contains("help: look here"), "{text}");
    assert!(text.contains("warning 18") && !text.contains("warning 19"), "{text}");
    assert!(text.ends_with("… and 11 more\n1 error, 30 warnings\n"), "{text}");
    assert_eq!(render::text(&Diags::new(), &Model::default(), false), "");
    assert!(render::text(&diags, &Model::default(), true).contains("\u{1b}["));
    assert_eq!(diags.list[0].severity, Severity::Warning);
}

#[test]
fn json_counts_lines_and_characters_from_one() {
    let (model, diags) = read("# é\n[MAS]\nb = { m = \"é\", mm = 2 }\n");
    let json = render::json(&diags, &model);
    let d = &json[0];
    assert_eq!((&d["code"], &d["severity"], &d["file"]), (&"E004".into(), &"error".into(), &"m.ca.toml".into()));
    let place = ["line", "column", "end_line", "end_column"].map(|k| d[k].as_u64().unwrap());
    assert_eq!(place, [3, 16, 3, 18]);
    assert_eq!(d["labels"][0]["text"], "not known here");
    let mut one = Diags::new();
    one.push(Diag::note("N201", "x"));
    let built = render::json(&one, &Model::default());
    assert!(built[0]["line"].is_null() && built[0]["fix"].is_null() && built[0]["title"] == "x");
}

#[test]
fn the_schema_holds_the_catalog() {
    let s = schema::schema(&catalog());
    for kind in catalog().iter() {
        let module = &s["$defs"][kind.code]["additionalProperties"];
        for p in kind.params {
            let doc = module["properties"][p.name]["description"].as_str();
            assert!(doc.is_some_and(|d| d.starts_with(p.doc)), "{}.{}", kind.code, p.name);
        }
        assert_eq!(module["properties"].as_object().unwrap().len(), kind.params.len());
    }
    let cel = &s["$defs"]["CEL"]["additionalProperties"];
    assert_eq!(cel["required"], serde_json::json!(["m"]));
    assert!(cel["allOf"].as_array().unwrap().contains(&serde_json::json!({"not": {"required": ["k", "f"]}})));
    assert_eq!(cel["properties"]["m"]["anyOf"][0]["exclusiveMinimum"], 0);
    for section in read::SECTIONS {
        assert!(s["properties"][section].is_object(), "{section}");
    }
}

/// Reads a text, renders its findings both ways, and checks them.
fn survives(text: &str) {
    let (model, diags) = read(text);
    let inside = |s: Span| !s.is_some() || s.start <= s.end && s.end <= text.len();
    for d in &diags.list {
        assert!(d.labels.iter().all(|l| inside(l.0)), "{d:?} in {text:?}");
        assert!(!d.labels.is_empty(), "{d:?} has no place in {text:?}");
        assert!(d.fix.as_ref().is_none_or(|f| inside(f.span)), "{d:?} in {text:?}");
    }
    let plain = render::text(&diags, &model, false);
    assert_eq!(plain.is_empty(), diags.list.is_empty());
    render::text(&diags, &model, true);
    assert_eq!(render::json(&diags, &model).as_array().unwrap().len(), diags.list.len());
}

proptest! {
    #[test]
    fn arbitrary_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        survives(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn text_of_the_alphabet_of_models(text in "([\\[\\]{}=\"', \\n#.]|MAS|SOL|ball|model|m|1|20 g|é|\\r\\n){0,60}") {
        survives(&text);
    }

    #[test]
    fn mutated_models(edits in prop::collection::vec((any::<prop::sample::Index>(), 0..6u8, "[\\[\\]{}=\"'\\\\,\\n#.a-zA-Z0-9é]{0,3}"), 1..6)) {
        let mut chars: Vec<char> = FULL.chars().collect();
        for (at, how, new) in edits {
            let i = at.index(chars.len());
            let end = (i + usize::from(how)).min(chars.len());
            chars.splice(i..end, new.chars());
        }
        survives(&chars.into_iter().collect::<String>());
    }

    #[test]
    fn a_parsed_text_is_left_as_it_is(at in any::<prop::sample::Index>()) {
        // cutting anywhere gives errors, but never a module that is not in the text
        let cut = at.index(FULL.len() + 1);
        let names: Vec<String> = clean(FULL).items.into_iter().map(|i| i.name).collect();
        for item in read(&FULL[..cut]).0.items {
            prop_assert!(names.iter().any(|n| n.starts_with(&item.name)), "{}", item.name);
        }
    }
}
