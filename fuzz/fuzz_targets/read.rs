//! Arbitrary bytes as a model file: read, compile, report, write, and read what was written.
//!
//! `cargo +nightly fuzz run read`, from the root of the repository. The folder `crates/ca-model/diagnostics` makes good seeds.
#![no_main]

use ca_compile::{Options, load};
use ca_model::{quantity, read, render, select, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    let _ = quantity::parse(&text);
    if let Ok(s) = select::parse(&text) {
        assert_eq!(select::parse(&s.to_string()), Ok(s));
    }
    let catalog = ca_model::catalog();
    let (model, diags) = read::read(&text, "fuzz", &catalog);
    for d in &diags.list {
        for (span, _) in &d.labels {
            assert!(span.start <= span.end && span.end <= text.len(), "{d:?}");
        }
    }
    render::text(&diags, &model, false);
    render::json(&diags, &model);
    let (model, result) = load(&text, "fuzz", &catalog, &Options::default());
    let found = result.map_or_else(|d| d, |compiled| compiled.findings);
    for d in &found.list {
        for (span, _) in &d.labels {
            assert!(!span.is_some() || span.start <= span.end && span.end <= text.len(), "{d:?}");
        }
    }
    render::text(&found, &model, false);
    let written = write::write(&model);
    if diags.list.is_empty() {
        let (again, diags) = read::read(&written, "again", &catalog);
        assert!(diags.list.is_empty(), "{written}\n{diags}");
        assert_eq!(again.items.len(), model.items.len());
        assert_eq!(write::write(&again), written);
    }
});
