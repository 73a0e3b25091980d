//! The page of error against run time has all scenes, and its claims hold and follow from its tables.

use crate::play::off;
use ca_benches::accuracy::page::rows;
use ca_benches::accuracy::{CASES, STIFF, stiffened};
use ca_core::tick;

const PAGE: &str = include_str!("../../../docs/measured/accuracy.md");

/// Number in a cell, which may be an upper bound.
fn number(cell: &str) -> f64 {
    cell.trim_start_matches("< ").parse().unwrap_or(f64::NAN)
}

/// Error and time in a row of a scene.
fn of(title: &str, row: &str) -> [f64; 2] {
    let all = rows(PAGE, title);
    let row = all.iter().find(|r| r[0].trim_end_matches(" *") == row).unwrap_or_else(|| panic!("no {row} in {title}"));
    [number(&row[1]), number(&row[6])]
}

#[test]
fn every_scene_is_on_the_page() {
    for case in &CASES {
        let all = rows(PAGE, case.title);
        assert!(all.len() >= 6, "{}: {} rows", case.title, all.len());
        assert!(all.iter().all(|r| r.len() == 9 && number(&r[6]) > 0.0), "{}: {all:?}", case.title);
        assert!(all.iter().any(|r| r[0].ends_with(" *")), "{}: nothing is best", case.title);
        let path = format!("{}/../docs/measured/accuracy/{}.svg", env!("CARGO_MANIFEST_DIR"), case.name);
        let picture = std::fs::read_to_string(&path).expect("a picture");
        let methods: std::collections::BTreeSet<&str> =
            all.iter().filter_map(|r| r[0].split_once(" ×").map(|(m, _)| m)).collect();
        assert_eq!(picture.matches("<circle").count(), all.len() + methods.len(), "{}", case.name);
        let scene = crate::play::scene(&(case.text)());
        let mut s = scene.state();
        (0..100).for_each(|_| tick(&scene, &mut s));
        assert!(s.is_bounded(1.0), "{}", case.title);
    }
    assert_eq!(rows(PAGE, "Links beyond the limit").len(), STIFF.len());
}

#[test]
fn what_is_expected_follows_from_the_tables() {
    let reported = rows(PAGE, "What is expected");
    let is = |what: &str| {
        let row = reported.iter().find(|r| r[0] == what).unwrap_or_else(|| panic!("no `{what}`"));
        assert!(number(&row[2]) <= number(&row[1]) && row[3] == "yes", "{row:?}");
        number(&row[2])
    };
    let string = CASES[0].title;
    let ([modal, modal_ns], [_, ns]) = (of(string, "modal ×1"), of(string, "as written ×1"));
    let ([fourth, fourth_ns], [fine, fine_ns]) = (of(string, "pefrl ×1"), of(string, "as written ×32"));
    assert!(off(is("error of `modal` over 0.1 s"), modal) < 0.06);
    assert!(off(is("time of `modal` over time of `ca`, 0.1 s"), modal_ns / ns) < 0.02);
    assert!(off(is("error of `pefrl` over error of `ca` at 32 times the rate"), fourth / fine) < 0.06);
    assert!(off(is("time of `pefrl` over time of `ca` at 32 times the rate"), fourth_ns / fine_ns) < 0.06);
    let stiff = rows(PAGE, "Links beyond the limit");
    assert!(off(is("time with one link 10⁶ beyond the limit over that without"), number(&stiff[1][4])) < 0.01);
    assert!(off(is("time with eight of 65 links 10⁶ beyond the limit over that without"), number(&stiff[2][4])) < 0.01);
    assert!(is("error of `modal` over 1 s") <= 1e-9 && is("time of `modal` over time of `ca`, 1 s") <= 2.0);
    assert_eq!(reported.len(), 8);
}

/// Scenes with stiff links are proven, and without the method they are a million times over the limit.
#[test]
fn stiff_links_are_beyond_the_limit() {
    let text = stiffened(1);
    assert!(crate::play::scene(&text).certificate.level == ca_core::Level::Proven);
    let bare = text.replace(", method = \"implicit\", theta = 0.25", "");
    assert!(crate::play::scene(&bare).certificate.level == ca_core::Level::Unstable);
}
