//! Files, examples and output are valid for a TOML 1.0 parser; a model in TOML 1.1 gets a note.

use ca_haptic::calibration::{Axis, Calibration};
use ca_haptic::profile::{Profile, SHIPPED};
use ca_model::{Model, read, write};
use ca_tests::catalog;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Files of the repository with these endings.
fn files(ends: &[&str]) -> Vec<PathBuf> {
    let (mut folders, mut found) = (vec![root()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("readable") {
            let path = entry.expect("readable").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            if path.is_dir() {
                if name != "target" && !name.starts_with('.') && !path.is_symlink() {
                    folders.push(path);
                }
            } else if ends.iter().any(|e| name.ends_with(e)) {
                found.push(path);
            }
        }
    }
    found
}

/// Blocks marked `toml` in a page or in source comments, each with its line.
fn blocks(text: &str) -> Vec<(usize, String)> {
    let bare = |l: &str| {
        let l = l.trim_start();
        let comment = l.strip_prefix("//!").or_else(|| l.strip_prefix("///"));
        comment.map_or(l, |c| c.strip_prefix(' ').unwrap_or(c)).to_owned()
    };
    let mut lines = text.lines().map(bare).enumerate();
    let mut found = Vec::new();
    while let Some((i, line)) = lines.next() {
        if line.strip_prefix("```").is_some_and(|mark| mark.split(',').any(|w| w.trim() == "toml")) {
            let body: Vec<String> = lines.by_ref().map(|l| l.1).take_while(|l| !l.starts_with("```")).collect();
            found.push((i + 1, body.join("\n") + "\n"));
        }
    }
    found
}

fn refused(text: &str) -> Option<String> {
    toml_1_0::from_str::<toml_1_0::Table>(text).err().map(|e| e.to_string())
}

fn says(text: &str, code: &str) -> bool {
    read::read(text, "toml.ca.toml", &catalog()).1.list.iter().any(|d| d.code == code)
}

#[test]
fn all_models_of_the_repository_are_toml_1_0() {
    let mut n = 0;
    for path in files(&[".ca.toml"]) {
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        assert_eq!(refused(&text), None, "{}", path.display());
        assert!(!says(&text, "N205"), "{}", path.display());
        n += 1;
    }
    assert!(n > 30, "{n}");
}

#[test]
fn all_that_is_shown_is_toml_1_0() {
    let (mut shown, mut wrong) = (0, 0);
    for path in files(&[".md", ".rs"]) {
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        for (line, block) in blocks(&text) {
            let at = format!("{}:{line}", path.display());
            // pages of findings show wrong models
            if ["E001", "E006", "E012", "E014", "N205"].iter().any(|code| says(&block, code)) {
                assert!(path.components().any(|c| c.as_os_str() == "diagnostics"), "{at}");
                wrong += usize::from(refused(&block).is_some());
                continue;
            }
            assert_eq!(refused(&block), None, "{at}");
            shown += 1;
        }
    }
    assert!(shown > 100 && wrong > 5, "{shown}, {wrong}");
    for kind in catalog().iter() {
        assert_eq!(refused(kind.example), None, "{}", kind.code);
    }
}

#[test]
fn what_is_written_is_toml_1_0() {
    for path in files(&[".ca.toml"]) {
        let text = std::fs::read_to_string(&path).expect("UTF-8");
        let model = read::read(&text, "it.ca.toml", &catalog()).0;
        assert_eq!(refused(&write::write(&model)), None, "{}", path.display());
    }
    let odd = Model { header: "a\u{1b}b\r".into(), ..Model::default() };
    assert_eq!(refused(&write::write(&odd)), None);
    let text = "[model]\ntitle = \"\\e[2J\\x01\\u0000\\u007f\\t\\\"\"\n[MAS]\n\"m\" = { m = 1e-300, x = -0.0 }\n";
    let written = write::write(&read::read(text, "it.ca.toml", &catalog()).0);
    assert_eq!(refused(&written), None, "{written}");
    for (name, _) in SHIPPED {
        assert_eq!(refused(&Profile::shipped(name).expect("shipped").write()), None, "{name}");
    }
    let axis = vec![Axis { scale: 0.1, offset: -1.0 / 3.0, force: 1e-7 }; 3];
    let text = Calibration { device: "a\u{1b}\nb".into(), by: "\"me\"".into(), axis }.write();
    assert_eq!(refused(&text), None, "{text}");
}

#[test]
fn what_is_only_toml_1_1_is_noted_where_it_stands() {
    let out = "[SOX]\nout = { from = \"m\" }\n";
    for (text, place) in [
        ("[MAS]\nm = {\n  m = 1\n}\n", "{"),
        ("[MAS]\nm = { # a mass\n  m = 1 }\n", "{"),
        ("[MAS]\nm = { m = 1,\n x = 0 }\n", "{"),
        ("[MAS]\nm = { m = 1, }\n", ","),
        ("[MAS]\nm = { m = 1 , }\n", ","),
        ("[model]\ntitle = \"a\\e\"\n[MAS]\nm = { m = 1 }\n", "\\e"),
        ("[model]\ntitle = \"a\\x41\"\n[MAS]\nm = { m = 1 }\n", "\\x"),
        ("[model]\ntitle = \"\"\"\na\\x41\"\"\"\n[MAS]\nm = { m = 1 }\n", "\\x"),
    ] {
        let text = format!("{text}{out}");
        assert!(refused(&text).is_some(), "{text}");
        let (model, found) = read::read(&text, "it.ca.toml", &catalog());
        let notes: Vec<_> = found.list.iter().filter(|d| d.code == "N205").collect();
        assert_eq!((notes.len(), found.list.len(), model.items.len()), (1, 1, 2), "{text}{found}");
        let span = notes[0].span();
        assert_eq!(&text[span.start..span.end], place, "{text}");
        // the proposed edit makes it TOML 1.0
        if let Some(fix) = &notes[0].fix {
            let mended = format!("{}{}{}", &text[..fix.span.start], fix.text, &text[fix.span.end..]);
            assert_eq!(refused(&mended), None, "{mended}");
        }
    }
    for text in [
        "[MAS]\nm = { m = 1, x = [\n  0, # here\n  0,\n] }\n",
        "[MAS]\nm.m = 1 # { m = 1, }\n",
        "[model]\ntitle = 'a\\x41'\n",
        "[model]\ntitle = \"a\\\\x41, }\"\n",
        "[MAS]\nm = {}\n",
    ] {
        assert_eq!((refused(text), says(text, "N205")), (None, false), "{text}");
    }
    assert!(says("[MAS]\nm = { m = 1,\n x = }\n", "E001") && !says("[MAS]\nm = { m = 1,\n x = }\n", "N205"));
}
