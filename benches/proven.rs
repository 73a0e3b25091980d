//! Verdict and run time of each bundled model, by its explicit links and by energy-consistent ones.
//!
//! Prints the page; with `UPDATE=1` writes it to `docs/measured/proven.md`. The verdicts are the same on every machine
//! and checked by a test; the times depend on the machine of the page.
#![allow(missing_docs)]

use ca_benches::proven::{measure, page};
use ca_benches::publish;
use std::path::Path;

/// Longest time that is played \[s\].
const SECONDS: f64 = 1.0;

fn main() {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let entries = std::fs::read_dir(folder).expect("the models");
    let mut files: Vec<_> = entries.map(|e| e.expect("a file").path()).filter(|p| p.is_file()).collect();
    files.sort();
    let rows = files.iter().take(if long { files.len() } else { 1 }).map(|path| {
        let file = path.file_name().expect("a name").to_string_lossy();
        let text = std::fs::read_to_string(path).expect("a model");
        let seconds = if long { SECONDS } else { 0.01 };
        let row = measure(file.trim_end_matches(".ca.toml"), &ca_benches::model(&text), seconds);
        eprintln!("{row:?}");
        row
    });
    let rows: Vec<_> = rows.collect();
    publish("proven", &page(&rows), long);
}
