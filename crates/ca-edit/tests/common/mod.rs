//! Bundled models, and what the tests ask about a text.

// each test file uses some of these
#![allow(dead_code)]

use ca_edit::{Edited, Operation, Refusal};
use cordis_anima::ca_model::read;
use cordis_anima::{Loaded, Options, catalog, render};
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models")
}

/// Returns the names and texts of all bundled models.
pub fn models() -> Vec<(String, String)> {
    let files = std::fs::read_dir(folder()).unwrap().map(|f| f.unwrap().path());
    let mut all: Vec<PathBuf> = files.filter(|f| f.extension().is_some_and(|e| e == "toml")).collect();
    all.sort();
    assert!(all.len() > 20);
    all.iter().map(|f| (f.file_name().unwrap().to_string_lossy().into(), std::fs::read_to_string(f).unwrap())).collect()
}

pub fn model(name: &str) -> String {
    std::fs::read_to_string(folder().join(format!("{name}.ca.toml"))).unwrap()
}

pub fn apply(text: &str, json: &str) -> Result<Edited, Refusal> {
    let operation: Operation = serde_json::from_str(json).unwrap_or_else(|e| panic!("{json}: {e}"));
    operation.apply(text, &catalog())
}

/// Applies an operation and returns the new text, which must differ only in the reported ranges.
pub fn edited(text: &str, json: &str) -> String {
    let e = apply(text, json).unwrap_or_else(|e| panic!("{json}: {e}"));
    check_edits(text, &e);
    e.text
}

/// Checks that the edits and ranges describe the difference.
pub fn check_edits(old: &str, e: &Edited) {
    assert_eq!(Edited::new(old, e.edits.clone()), *e);
    let mut kept = String::new();
    let mut at = 0;
    for r in &e.ranges {
        kept += &e.text[at..r.start];
        at = r.end;
    }
    kept += &e.text[at..];
    let mut rest = old.to_owned();
    e.edits.iter().rev().for_each(|t| rest.replace_range(t.range.clone(), ""));
    assert_eq!(kept, rest);
}

/// Returns the comments of a text.
pub fn comments(text: &str) -> Vec<(usize, String)> {
    let mut all = Vec::new();
    let (mut at, mut quote) = (0, None);
    for line in text.split_inclusive('\n') {
        for (i, c) in line.char_indices() {
            match (c, quote) {
                ('"' | '\'', None) => quote = Some(c),
                (c, Some(q)) if c == q => quote = None,
                ('#', None) => {
                    all.push((at + i, line[i..].trim_end().to_owned()));
                    break;
                }
                _ => {}
            }
        }
        quote = None;
        at += line.len();
    }
    all
}

/// Returns the codes of all errors.
pub fn errors(text: &str) -> Vec<&'static str> {
    let file = folder().join("x.ca.toml");
    match Loaded::read(text, &file.to_string_lossy()).compile(&Options::default()) {
        Ok(_) => Vec::new(),
        Err(found) => found.diags.list.iter().filter(|d| d.code.starts_with('E')).map(|d| d.code).collect(),
    }
}

/// Returns the errors that a text has as TOML.
pub fn syntax_errors(text: &str) -> usize {
    let found = read::written(text, "", &catalog()).1;
    found.list.iter().filter(|d| matches!(d.code, "E001" | "E012")).count()
}

/// Plays a model with its gesture for a time \[s\] and returns the bits of its samples.
pub fn sound(text: &str, seconds: f64) -> Vec<u64> {
    let file = folder().join("x.ca.toml");
    let compiled = Loaded::read(text, &file.to_string_lossy()).compile(&Options::default());
    let scene = compiled.unwrap_or_else(|e| panic!("{}\n{text}", e.diags)).scene;
    let sound = render(&scene, Some(seconds)).unwrap();
    sound.sound.iter().map(|s| s.to_bits()).collect()
}

/// Returns the names of everything that operations can name.
pub fn names(text: &str) -> Vec<String> {
    let model = read::written(text, "", &catalog()).0;
    let mut all = Vec::new();
    let bodies = std::iter::once((String::new(), &model));
    let bodies = bodies.chain(model.parts.iter().map(|p| (format!("part.{}.", p.name), &p.body)));
    for (before, body) in bodies {
        let plain = body.items.iter().map(|i| &i.name).chain(body.groups.iter().map(|g| &g.name));
        let plain = plain.chain(body.uses.iter().map(|u| &u.name));
        all.extend(plain.map(|n| format!("{before}{n}")));
        all.extend(body.params.iter().map(|p| format!("{before}param.{}", p.key)));
    }
    all.extend(model.parts.iter().map(|p| format!("part.{}", p.name)));
    all.extend(model.presets.iter().map(|p| format!("preset.{}", p.key)));
    all
}
