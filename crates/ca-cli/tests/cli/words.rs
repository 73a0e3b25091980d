//! Words of our own that the field has terms for stay out of code, messages and documents.

use crate::desk::from_root;
use std::fs;
use std::path::{Path, PathBuf};

/// What is not written any more, and the term. Split, so that this file does not hold them.
const WORDS: [(&str, &str, &str); 9] = [
    ("goes ", "wild", "diverges"),
    ("is_", "wild", "has_diverged"),
    ("looks ", "ahead", "is implicit"),
    ("look ", "ahead", "implicit"),
    ("energy ", "book", "energy ledger"),
    ("windows of ", "Hann", "Hann window"),
    ("greatest ", "sample", "peak"),
    ("fn ", "told", "reported, summary, percentiles"),
    ("struct ", "Told", "a name for what it holds"),
];

fn texts(dir: &Path, found: &mut Vec<PathBuf>) {
    for path in fs::read_dir(dir).unwrap().flatten().map(|e| e.path()) {
        let name = path.file_name().unwrap().to_str().unwrap();
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if path.is_dir() {
            if !name.starts_with('.') && !["target", "__pycache__", "proptest-regressions"].contains(&name) {
                texts(&path, found);
            }
        } else if ["rs", "py", "pyi", "md", "h", "c", "js"].contains(&ending) {
            found.push(path);
        }
    }
}

#[test]
fn terms_of_the_field_are_used() {
    let mut all = Vec::new();
    for folder in ["crates", "tests", "benches", "docs", "README.md"].map(from_root) {
        if folder.is_dir() { texts(&folder, &mut all) } else { all.push(folder) }
    }
    assert!(all.len() > 400, "{} files", all.len());
    for path in all {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        for (a, b, term) in WORDS {
            let word = format!("{a}{b}");
            let at = text.lines().position(|l| l.contains(&word));
            assert_eq!(at.map(|i| i + 1), None, "{}: the field says `{term}` for `{word}`", path.display());
        }
    }
}
