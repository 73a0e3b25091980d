//! The page of instruments agrees with measurements, has every bundled model, and each of its sentences is in a header
//! and true. `UPDATE=1` rewrites the figures; times, pictures and sounds come from `benches/instruments.rs`.

use ca_benches::instruments::page::{HEAD, page};
use ca_benches::instruments::{Figures, Instrument, Plays, all, figures, on_all_cores, one_line};
use ca_tests::long_form::long_form;
use std::path::PathBuf;
use std::sync::OnceLock;

fn measured() -> &'static [(&'static Instrument, Figures)] {
    static ALL: OnceLock<Vec<(&'static Instrument, Figures)>> = OnceLock::new();
    ALL.get_or_init(|| on_all_cores(|i| (i, figures(&Plays::new(i)))))
}

fn docs(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs").join(name)
}

fn bundled() -> Vec<String> {
    let names = std::fs::read_dir(docs("../models")).expect("models/ is there").map(|e| e.expect("a file").file_name());
    let mut names: Vec<String> = names.filter_map(|n| Some(n.to_str()?.strip_suffix(".ca.toml")?.to_owned())).collect();
    names.sort();
    names
}

/// Times on a page: the machine, and the cell of each instrument.
fn times_of(page: &str) -> Option<(&str, Vec<(&str, &str)>)> {
    let machine = page.strip_prefix(HEAD)?.split_once(".\n- **MAT")?.0;
    let rows = page
        .lines()
        .filter_map(|l| l.strip_prefix("| ["))
        .filter_map(|l| Some((l.split_once(']')?.0, l.split(" | ").nth(7)?)));
    Some((machine, rows.collect()))
}

/// Compares two pages. A number with a decimal point may differ by one in its last digit.
fn same(a: &str, b: &str) -> Result<(), String> {
    if a.lines().count() != b.lines().count() {
        return Err(format!("{} lines, not {}", a.lines().count(), b.lines().count()));
    }
    let near = |a: &str, b: &str| {
        let number = |t: &str| {
            let t = t.trim_matches(|c: char| "(),:;".contains(c)).replace('−', "-");
            Some((t.parse::<f64>().ok()?, t.split_once('.').map_or(0, |p| p.1.len())))
        };
        match (number(a), number(b)) {
            (Some((a, d)), Some((b, e))) => d == e && (a - b).abs() < 1.5 * 10f64.powi(-(d as i32)),
            _ => a == b,
        }
    };
    for (a, b) in a.lines().zip(b.lines()) {
        let words = [a, b].map(|l| l.split(' ').collect::<Vec<_>>());
        if words[0].len() != words[1].len() || !words[0].iter().zip(&words[1]).all(|(a, b)| near(a, b)) {
            return Err(format!("the page says\n{a}\nand measured is\n{b}"));
        }
    }
    Ok(())
}

#[test]
fn a_page_may_differ_by_one_of_the_last_digit() {
    assert!(same("| a | 1.25 |", "| a | 1.26 |").is_ok() && same("a (−0.3)", "a (−0.2)").is_ok());
    assert!(same("| a | 1.25 |", "| a | 1.27 |").is_err() && same("| a |", "| b |").is_err());
    assert!(same("0.1", "0.10").is_err() && same("a\nb", "a").is_err());
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
            if !header.contains(&one_line(c.sentence)) {
                wrong.push(format!("{}: its header does not say “{}”", i.model, c.sentence));
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
            let [least, most] = c.range;
            if !(least..=most).contains(figure) {
                wrong.push(format!("{}: “{}”: {figure} is not within {least} to {most}", i.model, c.sentence));
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
