//! Arbitrary bytes as a MIMS model: import, report, compile what came of it, write it and read it again.
//!
//! `cargo +nightly fuzz run mims`, from the root of the repository. The folder `tests/mims` makes good seeds.
#![no_main]

use ca_compile::{Options, compile};
use ca_import::mims;
use ca_model::{read, render, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data);
    let (model, diags) = mims::import(&text, "fuzz.mdl");
    for (span, _) in diags.list.iter().flat_map(|d| &d.labels) {
        assert!(!span.is_some() || span.start <= span.end && span.end <= text.len());
    }
    render::text(&diags, &model, false);
    if diags.has_errors() {
        return;
    }
    let catalog = ca_model::catalog();
    let (again, found) = read::read(&write::write(&model), "again", &catalog);
    assert!(found.list.is_empty(), "{found}");
    for m in [&model, &again] {
        if let Err(e) = compile(m, &catalog, &Options::default()) {
            assert!(e.has_errors());
            render::text(&e, m, false);
        }
    }
});
