//! The page of costs is the one of the bench, has every method and every rule of the guard, and shows that no scene has
//! parts it does not use. The numbers depend on build and machine and are left to `benches/costs.rs`.

use ca_benches::costs::page::{HEAD, proof};
use ca_benches::costs::rows;
use ca_core::Type;
use ca_core::internal::phi::implicit::{OF_GROUP, OF_MODEL};
use std::collections::BTreeSet;

const PAGE: &str = include_str!("../../../docs/measured/costs.md");

/// Cells of each table row except heads.
fn table() -> Vec<Vec<&'static str>> {
    let lines = PAGE.lines().filter(|l| l.starts_with("| ") && !l.starts_with("| thing |"));
    lines.map(|l| l.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

#[test]
fn the_page_has_the_rows_the_bench_makes() {
    assert!(PAGE.starts_with(HEAD), "`UPDATE=1 cargo bench -p ca-benches --bench costs` makes it anew");
    // costs of every scene come last, on the page and here
    let (there, made) = (table(), rows());
    assert_eq!(there.len(), made.len());
    let key = |thing: &str, with: &str| format!("{thing} | {with}");
    let mut names: Vec<String> = there.iter().map(|c| key(c[0], c[1])).collect();
    let mut wanted: Vec<String> = made.iter().map(|r| key(r.thing, r.with)).collect();
    names.sort();
    wanted.sort();
    assert_eq!(names, wanted);
    assert!(names.windows(2).all(|n| n[0] != n[1]), "a row twice");
    for cells in there {
        let row = made.iter().find(|r| key(r.thing, r.with) == key(cells[0], cells[1])).expect("found before");
        for cell in &cells[2..4] {
            let n: f64 = cell.replace('−', "-").parse().unwrap_or(f64::NAN);
            assert!(n.is_finite(), "{cells:?}");
        }
        assert_eq!(cells.get(4).copied().unwrap_or(""), proof(&row.without), "{cells:?}");
    }
}

#[test]
fn every_method_is_on_the_page() {
    let kinds = ca_tests::catalog();
    let of_kinds = kinds.iter().flat_map(|k| k.params.iter()).filter(|p| p.name == "method").map(|p| p.ty);
    let mut words = BTreeSet::new();
    for kind in of_kinds.chain([OF_GROUP.ty, OF_MODEL.ty]) {
        let Type::Choice(of) = kind else { panic!("a method that is no word") };
        words.extend(of);
    }
    // and `auto` chooses among the others
    assert!(words.remove("auto") && words.remove("ca") && PAGE.contains("Methods are beside `ca`"));
    let reported = table().into_iter().filter_map(|c| c[0].strip_prefix("method ").map(|m| m.trim_matches('`')));
    assert_eq!(reported.collect::<BTreeSet<_>>(), words);
}

#[test]
fn every_rule_of_the_guard_is_on_the_page() {
    let rules = |text: &'static str| -> BTreeSet<&str> {
        let is_rule = |w: &&str| w.strip_prefix('H').is_some_and(|n| n.parse::<u32>().is_ok());
        text.split(|c: char| !c.is_alphanumeric()).filter(is_rule).collect()
    };
    let there = rules(include_str!("../../../docs/safety.md"));
    assert!(there.len() >= 18 && there.is_subset(&rules(PAGE)), "{there:?}");
}

#[test]
fn a_scene_has_nothing_of_what_it_does_not_use() {
    let wrong: Vec<String> =
        rows().iter().filter_map(|r| Some(format!("{}, {}: {}", r.thing, r.with, r.nothing().err()?))).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
