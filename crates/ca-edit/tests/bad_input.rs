//! Operations on texts and with names that are wrong in any way: refusals, no panic.

mod common;

use ca_edit::{Document, Edited, Operation, diagnostics};
use cordis_anima::{Options, catalog};
use proptest::prelude::*;
use serde_json::json;

fn all(name: &str, value: &str) -> Vec<Operation> {
    let list = [
        json!({"type": "add", "kind": name, "name": value, "values": {name: value}, "into": name}),
        json!({"type": "add", "kind": "MAS", "name": name, "values": {"m": value}}),
        json!({"type": "add", "kind": "STRING", "into": name}),
        json!({"type": "instance", "part": name, "name": value, "n": 4_000_000_000_u32, "with": {name: value}}),
        json!({"type": "instance", "part": "plectrum", "with": {"on": name, "note": value}}),
        json!({"type": "join", "kind": "RES", "from": name, "to": value, "values": {"k": value}}),
        json!({"type": "set", "name": name, "value": value}),
        json!({"type": "set", "name": format!("{name}.{value}"), "value": value}),
        json!({"type": "set", "name": format!("{name}[{value}]"), "value": value}),
        json!({"type": "clear", "name": name}),
        json!({"type": "rename", "name": name, "to": value}),
        json!({"type": "rename", "name": "low", "to": name}),
        json!({"type": "delete", "names": [name, value], "dependents": true}),
        json!({"type": "duplicate", "names": [name, value, name]}),
        json!({"type": "group", "names": [name, "low"], "part": value, "instance": name}),
        json!({"type": "move", "name": name, "x": [1e300, -0.0]}),
        json!({"type": "move", "name": "low", "x": []}),
        json!({"type": "midi", "name": name, "source": {"note": {"first": value}}, "from": value, "to": value}),
        json!({"type": "device", "name": name, "device": value, "dof": [4_000_000_000_u32]}),
        json!({"type": "equivalence", "rows": {name: value}, "anchor": name, "key": value, "lever": 1e300}),
    ];
    list.map(|j| serde_json::from_value(j).unwrap()).into()
}

fn check(text: &str, name: &str, value: &str) {
    for operation in all(name, value) {
        match operation.apply(text, &catalog()) {
            Ok(e) => {
                common::check_edits(text, &e);
                assert!(Document::read(&e.text).is_ok());
            }
            Err(e) => assert!(!e.what.is_empty() && !e.help.is_empty(), "{operation:?}"),
        }
        assert!(!operation.title().is_empty());
    }
}

#[test]
fn texts_that_are_not_toml_are_refused() {
    let deep = format!("a = {}1{}", "[".repeat(100), "]".repeat(100));
    let texts =
        ["a = ", "[MAS", "[MAS]\nbob = { m = \"1 g\"", "\"", "= 1", "a = \"\\q\"", "a = 1 2", deep.as_str(), "\u{0}"];
    for text in texts {
        for operation in all("bob", "1") {
            let e = operation.apply(text, &catalog()).unwrap_err();
            assert!(e.what.starts_with("cannot edit the text: line "), "{text}: {e}");
        }
        let mut open = |_: &str| unreachable!();
        let found = diagnostics(text, &catalog(), &Options::default(), &mut open);
        assert!(found.iter().any(|d| d.severity == "error"), "{text}");
    }
}

#[test]
fn odd_names_and_values_are_refused_or_written() {
    let text = "[MAS]\nlow = { m = \"1 g\" }\n\"é.x\" = {}\n[[a]]\nb = 1\n[use]\nu = \"x.toml\"\nv = 3\n[preset]\np = 1\n[part]\nq = 2\n";
    let words = [
        "",
        " ",
        "low",
        "low ",
        "é",
        "é.x",
        "a\nb",
        "\"",
        "'",
        "\\",
        "a.b",
        ".",
        "..",
        "low.",
        ".low",
        "low[",
        "low]",
        "low[]",
        "low[0]",
        "low[-1]",
        "low[99999999999999999999]",
        "low@",
        "low@0.3,1,2",
        "part",
        "part.",
        "part.q",
        "part.q.x",
        "use",
        "use.u",
        "use.u.n",
        "u",
        "u.x",
        "v.n",
        "param",
        "param.",
        "preset.p",
        "preset.p.x",
        "gesture",
        "gesture.x",
        "model",
        "a",
        "a.b",
        "1e999",
        "-1e-999",
        "0x10",
        "nan",
        "inf",
        "1_000",
        "[1",
        "{}",
        "{ a = 1 }",
        "[\n1,\n]",
        "# c",
        "1 # c",
        "\u{feff}",
        "\u{202e}",
        "\u{0}",
        "true",
        "2 N/m",
    ];
    for name in words {
        for value in words {
            check(text, name, value);
        }
    }
    // names of the reader that are longer, or of instances written out
    let written =
        format!("[g-.MAS]\na = {{}}\n[\"k[3]\".MAS]\n{0} = {{}}\n[part.{0}.MAS]\nb = {{}}\n", "x".repeat(300));
    let x = "x".repeat(300);
    for name in [format!("k[3].{x}"), x, "k[3]".into(), "k[3].b".into(), "g-".into()] {
        check(&written, &name, "y");
        check(&written, "y", &name);
    }
    let long = "x".repeat(1 << 20);
    check(text, &long, &long);
    assert!(serde_json::from_str::<Operation>(r#"{"type": "set", "name": "a", "value": "1", "more": 1}"#).is_err());
    assert!(serde_json::from_str::<Operation>(r#"{"type": "fly"}"#).is_err());
    let out = Edited::new("ab", vec![ca_edit::TextEdit { range: 1..usize::MAX, text: "x".into() }]);
    assert_eq!(out.text, "ab");
}

proptest! {
    /// Any text, or a model with any bytes changed.
    #[test]
    fn any_text_is_edited_or_refused(text in ".{0,200}", at in 0_usize..4000, new in "[\\[\\]{}=.\"' \na-z0-9é]{0,8}", name in "[a-z.\\[\\]0-9@*\"]{0,12}") {
        check(&text, &name, &new);
        let mut model = common::model("plucked_string");
        let at = (0..=at.min(model.len())).rev().find(|i| model.is_char_boundary(*i)).unwrap_or(0);
        let end = (at + 3..model.len()).find(|i| model.is_char_boundary(*i)).unwrap_or(model.len());
        model.replace_range(at..end.max(at), &new);
        check(&model, "low", &name);
        check(&model, &name, "pick");
    }
}
