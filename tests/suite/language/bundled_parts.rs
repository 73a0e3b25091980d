//! Shipped parts are usable without a file, and parts of the model or its files take precedence.

use crate::language::parts::found;
use ca_compile::Options;
use ca_model::part::library::{LIBRARY, shipped};
use ca_model::{Entry, Value, render};
use ca_tests::catalog;

fn with_shipped(name: &str) -> String {
    let (part, header) = shipped(name, &catalog()).expect(name);
    assert!(!part.doc.is_empty() && !header.is_empty(), "{name} says what it is");
    assert!(part.body.params.iter().all(|p| matches!(&p.value, Value::Table(t) if t.iter().any(|e| e.key == "doc"))));
    let value = |key: &str| match key {
        "on" => "low[8]",
        "note" => "C4",
        "key" => "hand",
        "f" | "f2" => "220 Hz",
        "tie" => "10 kN/m",
        other => panic!("{name}: nothing is known of `{other}`"),
    };
    let has = |p: &Entry| matches!(&p.value, Value::Table(t) if t.iter().any(|e| e.key == "value" || e.key == "port"));
    let needed = part.body.params.iter().filter(|p| !has(p)).map(|p| format!("{} = \"{}\"", p.key, value(&p.key)));
    let with: Vec<String> = needed.collect();
    let hand = if with.iter().any(|w| w.starts_with("key")) { "[TGR]\nhand = {}\n" } else { "" };
    format!(
        "[STRING]\nlow = {{ n = 24, f = \"196 Hz\", t60 = \"2 s\", m = \"1 g\" }}\n{hand}\
         [use]\nit = {{ part = \"{name}\", with = {{ {} }} }}\n[SOX]\nout = {{ from = \"low[3]\", gain = 1 }}\n",
        with.join(", ")
    )
}

#[test]
fn parts_of_the_program_are_used_without_a_file() {
    for (name, text) in LIBRARY {
        let (model, diags) = found(&with_shipped(name), &[]);
        assert!(!diags.has_errors(), "{name}: {}", render::text(&diags, &model, false));
        let file = format!("ca:{name}.ca.toml");
        assert!(model.files.iter().any(|f| f.name == file && f.text == *text), "its text is one of the files");
        let compiled = ca_compile::compile(&model, &catalog(), &Options::default()).expect("a scene");
        let (part, _) = shipped(name, &catalog()).expect(name);
        for key in part.body.items.iter().filter(|i| i.kind == "TGR") {
            let port = format!("it.{}", key.name);
            assert!(compiled.scene.inputs.iter().any(|i| i.name == port), "{name} is played by `{port}`");
        }
    }
    let names: Vec<&str> = LIBRARY.iter().map(|p| p.0).collect();
    let mut folder: Vec<String> = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../models/parts"))
        .expect("the folder")
        .map(|f| f.expect("a file").file_name().into_string().expect("a name").replace(".ca.toml", ""))
        .collect();
    folder.sort();
    assert_eq!(names, folder, "all of the folder, in order");
}

#[test]
fn a_part_of_the_model_or_a_text_at_hand_comes_before_that_of_the_program() {
    let own = format!(
        "[part.plectrum.MAS]\nmine = {{ m = \"1 g\" }}\n{}",
        with_shipped("plectrum").replace("with", "n = 1, with")
    );
    let own = own.replace("on = \"low[8]\", note = \"C4\"", "");
    assert!(found(&own, &[]).0.items.iter().any(|i| i.name == "it[0].mine"));
    let old = "[part.plectrum.param]\non = {}\nnote = {}\n[part.plectrum.MAS]\nold = { m = \"1 g\" }\n";
    let (model, _) = found(&with_shipped("plectrum"), &[("ca:plectrum.ca.toml", old)]);
    assert!(model.items.iter().any(|i| i.name == "it.old"), "a take is replayed with its own text");
    let (model, diags) = found(&with_shipped("plectrum").replace("\"plectrum\"", "\"plectrun\""), &[]);
    assert!(render::text(&diags, &model, false).contains("did you mean `plectrum`?"));
}
