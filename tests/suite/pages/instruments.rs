//! The page of instruments says what is measured, every bundled model is on it, and each sentence stands in a header and is so.
//! `UPDATE=1` writes the figures anew; times, pictures and sounds are of the bench, `benches/instruments.rs`.

use ca_benches::instruments::page::{page, same, times_of};
use ca_benches::instruments::{Figures, Instrument, Plays, all, bundled, figures, on_all_cores, one_line};
use ca_tests::long_form::long_form;
use std::path::PathBuf;
use std::sync::OnceLock;

/// What is measured of all, once.
fn measured() -> &'static [(&'static Instrument, Figures)] {
    static ALL: OnceLock<Vec<(&'static Instrument, Figures)>> = OnceLock::new();
    ALL.get_or_init(|| on_all_cores(|i| (i, figures(&Plays::new(i)))))
}

fn docs(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name)
}

#[test]
fn every_bundled_model_has_an_entry() {
    let names: Vec<&str> = all().iter().map(|i| i.model).collect();
    assert_eq!(names, bundled(), "a model without an entry in benches/src/instruments, or an entry without a model");
}

#[test]
fn what_is_claimed_stands_in_the_header() {
    let mut wrong = Vec::new();
    for i in all() {
        let header = one_line(&i.load().model.header);
        for c in i.claims {
            if !header.contains(&one_line(c.says)) {
                wrong.push(format!("{}: its header does not say “{}”", i.model, c.says));
            }
            assert_eq!(c.shows.matches("{}").count(), 1, "{}: a figure has one place in “{}”", i.model, c.shows);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_is_claimed_is_so() {
    if !long_form("the figures that headers of instruments claim") {
        return;
    }
    let mut wrong = Vec::new();
    for (i, f) in measured() {
        for (c, figure) in i.claims.iter().zip(&f.claims) {
            let [least, most] = c.keeps;
            if !(least..=most).contains(figure) {
                wrong.push(format!("{}: “{}”: {figure} is not within {least} to {most}", i.model, c.says));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_page_of_instruments_says_what_is_measured() {
    if !long_form("the figures on the page of instruments") && std::env::var_os("UPDATE").is_none() {
        return;
    }
    let is = std::fs::read_to_string(docs("instruments.md")).unwrap_or_default();
    let (machine, times) = times_of(&is).unwrap_or_default();
    let time = |name: &str| times.iter().find(|t| t.0 == name).map_or("–", |t| t.1).to_owned();
    let want = page(measured(), machine, &time);
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(docs("instruments.md"), &want).unwrap();
    } else if let Err(why) = same(&is, &want) {
        panic!(
            "docs/instruments.md is stale: {why}\n`UPDATE=1 cargo bench -p ca-benches --bench instruments` writes it"
        );
    }
}

#[test]
fn each_instrument_has_a_picture_and_a_short_sound() {
    for i in all() {
        for (ending, begins, most) in [("png", &b"\x89PNG"[..], 150_000), ("flac", b"fLaC", 200_000)] {
            let path = docs("instruments").join(format!("{}.{ending}", i.model));
            let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            assert!(bytes.starts_with(begins) && bytes.len() < most, "{}: {} bytes", path.display(), bytes.len());
        }
    }
}
