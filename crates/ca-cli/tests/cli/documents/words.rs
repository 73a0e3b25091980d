//! Checks that code, messages and documents use the terms of the field instead of private words.

use crate::documents::docs::texts;
use crate::sandbox::from_root;
use std::fs;

/// Words to avoid, in two parts so that this file does not match, and the proper term.
const WORDS: [(&str, &str, &str); 63] = [
    ("goes ", "wild", "diverges"),
    ("is_", "wild", "has_diverged"),
    ("looks ", "ahead", "is implicit"),
    ("look ", "ahead", "implicit"),
    ("energy ", "book", "energy ledger"),
    ("windows of ", "Hann", "Hann window"),
    ("greatest ", "sample", "peak"),
    ("fn to", "ld", "reported, summary, percentiles"),
    ("struct To", "ld", "a name for what it holds"),
    ("energy     cl", "oses", "accounted for"),
    ("enum A", "ct {", "EngineCommand"),
    ("enum Sp", "ent {", "Retired"),
    ("enum Tu", "rn {", "SolveStage"),
    ("enum E", "ar {", "OutputTap"),
    ("struct In", "let {", "InputValidator"),
    ("struct As", "ide", "AsyncSink"),
    ("struct Ne", "ar {", "VerletList"),
    ("struct Cr", "owd {", "PairSet"),
    ("struct Be", "at {", "FrameTiming"),
    ("struct Pu", "lse {", "StatsSnapshot"),
    ("mod deb", "ris", "stale_shm"),
    ("blew ", "up", "diverged"),
    ("blown ", "up", "diverged"),
    ("blow ", "up", "diverge"),
    ("blows ", "up", "diverges"),
    ("Ga", "uge", "MeasureKind"),
    ("Fin", "er {", "Substeps"),
    ("struct Ske", "tch", "Builder"),
    ("walk", "able", "set_path"),
    ("\"adva", "nce ", "integrate"),
    ("struct Tr", "uth", "Reference"),
    ("scene.t", "e ", "sample_dt"),
    ("net.t", "e ", "tick_dt"),
    ("struct Di", "ce", "Random"),
    ("struct Men", "der", "Brackets"),
    ("struct Cei", "ling", "PeakLimit"),
    ("struct Kn", "ob", "Variable"),
    ("struct Be", "ll ", "Wakeup"),
    ("struct Bro", "ke", "Divergence"),
    ("_bo", "ok_", "ledger"),
    ("is_so", "und", "is_bounded"),
    ("swallowed by", " the scheme", "taken by the scheme"),
    ("border bo", "oked", "ledger of the border"),
    ("fn go", "es(", "free_motion"),
    ("fn is_la", "te(", "is_staged"),
    ("layout::He", "ard", "Tap"),
    ("fn cul", "prit", "largest_error"),
    ("struct Pen", "cil", "StabilityMatrix"),
    ("struct Lo", "ose", "MovingLink"),
    ("enum Thr", "ough", "Termination"),
    ("struct Pro", "xy {", "MovingPoint"),
    ("struct As", "k", "options, arguments, specification"),
    ("struct Wa", "nts", "SinkStreams"),
    ("struct Hap", "pened", "Notice"),
    ("struct Wi", "sh", "options, request"),
    ("enum Str", "ange", "FrameMismatch"),
    ("struct Ev", "ery", "RecordIntervals"),
    ("struct Su", "ng", "ModesPart"),
    ("TW", "INS", "QUADRIPOLES"),
    ("const T", "E: f64", "FRAME_DT"),
    ("later ", "version\"", "what it is not possible with"),
    ("leans ", "on", "is supported by"),
    ("damping ", "ties", "couples"),
];

#[test]
fn terms_of_the_field_are_used() {
    let mut all = Vec::new();
    for folder in ["crates", "tests", "benches", "docs", "README.md", "CONTRIBUTING.md"].map(from_root) {
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
