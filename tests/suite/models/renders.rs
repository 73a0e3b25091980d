//! Bundled models sound as before, to the bit: `tests/data/renders.txt` has a hash of the sound of each.
//!
//! One list holds for every processor, vector width and build, as `ARITHMETIC` promises to takes. After an intended
//! change of a model or law, `UPDATE=1 cargo test $ALL --test suite -- renders` rewrites it (`$ALL` is in
//! CONTRIBUTING.md).

use ca_benches::instruments::{BUILT, Plays, on_all_cores};
use ca_core::ARITHMETIC;
use ca_tests::long_form::long_form;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Seconds of each model in the core suite \[s\].
const FIRST: f64 = 1.0;

/// Hash of all channels, each as its length and its samples as little-endian doubles.
fn hash(sound: &[Vec<f64>]) -> String {
    let mut hasher = blake3::Hasher::new();
    for channel in sound {
        hasher.update(&(channel.len() as u64).to_le_bytes());
        for x in channel {
            hasher.update(&x.to_le_bytes());
        }
    }
    hasher.finalize().to_hex()[..16].to_string()
}

/// A line for each model: name, hash of the first second, and hash of the whole gesture.
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
    let was = std::fs::read_to_string(&path).unwrap_or_default();
    let words = |line: &str| line.split_whitespace().take(if whole { 3 } else { 2 }).collect::<Vec<_>>().join(" ");
    let less = |a: &str, b: &str| {
        let b: Vec<String> = b.lines().map(words).collect();
        a.lines().map(words).filter(|l| !b.contains(l)).collect::<Vec<_>>().join("\n")
    };
    let (new, gone) = (less(&is, &was), less(&was, &is));
    let changed = format!(
        "tests/data/renders.txt has\n{gone}\nand it is\n{new}\nWhere a model is as it was, raise `ARITHMETIC`; \
         `UPDATE=1 cargo test $ALL --test suite -- renders` ($ALL is in CONTRIBUTING.md) writes the list"
    );
    if update {
        eprintln!("{changed}");
        std::fs::write(&path, &is).expect("tests/data is there");
        return;
    }
    assert!(new.is_empty() && gone.is_empty(), "{changed}");
}
