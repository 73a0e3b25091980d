//! Bundled models sound as they did, to the bit: `tests/data/renders.txt` has a hash of the sound of each.
//!
//! The same list holds for every processor, width of vectors and build, which is what `ARITHMETIC` promises to takes.
//! Where a model or a law is changed on purpose, `UPDATE=1 cargo test $ALL --test suite -- renders` writes it anew (`$ALL` is
//! in CONTRIBUTING.md).

use ca_benches::instruments::{BUILT, Plays, on_all_cores};
use ca_core::ARITHMETIC;
use ca_tests::long_form::long_form;
use std::fmt::Write as _;
use std::path::PathBuf;

/// How long all of them sound where not all is played \[s\].
const FIRST: f64 = 1.0;

/// The hash of all channels, one after the other; samples as doubles, least byte first.
fn hash(sound: &[Vec<f64>]) -> String {
    let mut hasher = blake3::Hasher::new();
    for x in sound.iter().flatten() {
        hasher.update(&x.to_le_bytes());
    }
    hasher.finalize().to_hex()[..16].to_string()
}

/// A line for each model: its name, the hash of its first second, and of all that its gesture plays.
fn list(whole: bool) -> String {
    let lines = on_all_cores(|i| {
        let plays = Plays::new(i);
        let first = hash(&plays.render(BUILT.seconds(FIRST), &[]).sound);
        let all = if whole { hash(&plays.render(BUILT, &[]).sound) } else { String::new() };
        format!("{} {first} {all}", i.model)
    });
    lines.iter().fold(format!("arithmetic {ARITHMETIC}\n"), |mut out, line| {
        let _ = writeln!(out, "{}", line.trim_end());
        out
    })
}

#[test]
fn bundled_models_sound_as_they_did_to_the_bit() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/renders.txt");
    let update = std::env::var_os("UPDATE").is_some();
    let whole = long_form("renders of bundled models after their first second") || update;
    let is = list(whole);
    if update {
        std::fs::write(&path, &is).expect("tests/data is there");
    }
    let was = std::fs::read_to_string(&path).expect("tests/data/renders.txt, which UPDATE=1 writes");
    let words = |line: &str| line.split_whitespace().take(if whole { 3 } else { 2 }).collect::<Vec<_>>().join(" ");
    let changed: Vec<_> = is.lines().filter(|l| !was.lines().any(|w| words(w) == words(l))).map(words).collect();
    assert!(
        changed.is_empty() && is.lines().count() == was.lines().count(),
        "these sound otherwise than when tests/data/renders.txt was written, or one is new or gone:\n{}\n\
         where that is meant: raise `ARITHMETIC` if their models are as they were, and write the list by \
         `UPDATE=1 cargo test $ALL --test suite -- renders`",
        changed.join("\n")
    );
}
