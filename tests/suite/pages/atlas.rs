//! The stability atlas: coarse maps by the functions that make `docs/measured/atlas.md`, the survival table, and
//! non-finite numbers at every input.

use crate::play::{case, list, num, off, within};
use ca_benches::atlas::page::{DOORS, entry_point, row};
use ca_benches::atlas::survival::{CASES, Case, METHODS, Outcome};
use ca_benches::atlas::{Cell, MAPS, contact, exact, limit, ratio, svg};
use std::collections::BTreeSet;

const PAGE: &str = include_str!("../../../docs/measured/atlas.md");

#[test]
fn no_cell_of_any_map_contradicts_theory() {
    for map in MAPS {
        let field = map.play(9, 7);
        let wrong: Vec<_> = field.cells.iter().filter(|c| c.contradicts()).collect();
        assert!(wrong.is_empty(), "{}: {wrong:?}", map.name);
        assert!(field.judged() >= 40, "{}: theory says something of {} cells only", map.name, field.judged());
        // the map covers both sides of each boundary in theory
        let said = |grows: bool| field.cells.iter().filter(|c| c.theory == Some(grows)).count();
        if (map.lines)().is_empty() {
            continue;
        }
        assert!(said(false) >= 5 && said(true) >= 5, "{}", map.name);
        // a boundary wrong by a quarter would be detected
        for off in [0.8, 1.25] {
            let other = |c: &&Cell| (map.theory)(c.at[0] * off, c.at[1] * off).is_some_and(|said| said != c.grows);
            assert!(field.cells.iter().any(|c| other(&c)), "{}: nothing tells theory × {off}", map.name);
        }
    }
}

/// Bounds of one undamped bounce, and the closed form behind its map.
#[test]
fn c01_a_bounce_is_what_the_closed_form_says() {
    let (mut worst, mut out) = (0.0f64, 0.0f64);
    for i in 1..80 {
        let a = 0.05 * f64::from(i);
        let scene = contact(a, 0.0, "ca");
        let start = scene.state();
        for p in 0..50 {
            let phase = (f64::from(p) + 0.5) / 50.0;
            let is = ratio(&scene, &start, phase);
            worst = worst.max(off(is, exact(a, phase)));
            out = out.max((1.0 - 0.25 * a) - is).max(is * (1.0 - 0.25 * a) - 1.0);
        }
    }
    within("C01 against the closed form", worst, 1e-13);
    within("C01 beyond [1 - a/4, 1/(1 - a/4)]", out, 1e-12);
}

/// The boundary of the device maps at the device of E02; passivity is on its safe side for every device.
#[test]
fn e02_the_boundary_of_the_device_maps() {
    let c = case("E02");
    let beta = num(c, "setup/bd") / 3000.0 / num(c, "setup/md");
    let rows = crate::play::rows(c, "values/rows");
    for (kappa, row) in [(0.5, 0), (1.0, 1), (1.5, 3), (2.0, 4)] {
        let k = limit(kappa, beta) * num(c, "setup/bd") * 3000.0;
        within(&format!("E02 κ = {kappa}"), off(k, rows[row][1]), 1e-8);
        for e in -40..=20 {
            let beta = 10f64.powf(0.1 * f64::from(e));
            assert!(limit(kappa, beta) * kappa > 1.0, "κ = {kappa}, b T/m = {beta}");
        }
    }
}

/// Outcome of one case by one method, played as long as in the core suite.
fn played(case: Case, method: &str) -> Outcome {
    let method = METHODS.iter().find(|m| m.name == method).expect("a method");
    case.outcome(&(method.text)(&case).expect("it has a part in it"), case.ticks()[1])
}

/// The columns of docs/numerics.md §3.6.
#[test]
fn the_survival_table() {
    let largest = |a: f64, b: f64| match played(Case::Oscillator(a, b), "ca") {
        Outcome::Largest(x, rises) => (x, rises),
        other => panic!("a = {a}, b = {b}: {other:?}"),
    };
    let blown = |a: f64, b: f64| match played(Case::Oscillator(a, b), "ca") {
        Outcome::Blown(factor, ticks) => (factor, ticks),
        other => panic!("a = {a}, b = {b}: {other:?}"),
    };
    let a03 = case("A03");
    let (bounded, rises) = (largest(3.99, 0.0), largest(4.0, 0.0));
    within("A03 a = 3.99", off(bounded.0, num(a03, "values/max_abs_a_3_99")), num(a03, "tolerance/max_rel"));
    within("A03 a = 4", off(rises.0, num(a03, "values/max_abs_a_4_0")), num(a03, "tolerance/max_rel"));
    assert!(!bounded.1 && rises.1);
    let growth = num(a03, "values/growth_per_sample_a_4_01");
    within("A03 a = 4.01", off(blown(4.01, 0.0).0, growth), num(a03, "tolerance/growth_rel"));
    // the larger root of w² − (2 − a − b) w + (1 − b), docs/numerics.md §1.3
    let root = |a: f64, b: f64| {
        let half = 0.5 * (a + b) - 1.0;
        half + (half * half - 1.0 + b).sqrt()
    };
    let a15 = case("A15");
    for a in list(a15, "setup/a").into_iter().chain([4e16]) {
        within(&format!("A15 explicit, a = {a:e}"), off(blown(a, 0.0).0, root(a, 0.0)), 1e-14);
    }
    let h04 = case("H04");
    assert_eq!(h04["values"]["CA"], "inf");
    for b in list(h04, "setup/b").into_iter().chain([1.96]) {
        within(&format!("H04 b = {b:e}"), off(blown(num(h04, "setup/a"), b).0, root(0.1, b)), 1e-14);
    }
    assert_eq!(largest(0.1, 1.94), (1.0, false));

    // implicit links survive what explicit links do not: docs/numerics.md §3.6
    let by = |case: Case, method: &str| match played(case, method) {
        Outcome::Largest(x, rises) => (x, rises),
        other => panic!("{case:?} by {method}: {other:?}"),
    };
    for a in [4.01, 1e6, 1e12, 4e16] {
        let (x, rises) = by(Case::Oscillator(a, 0.0), "implicit 1/2");
        assert!(x <= num(a15, "tolerance/theta_half_max") && !rises, "a = {a:e}: {x}");
    }
    for b in list(h04, "setup/b") {
        for method in ["centred", "implicit 1/4", "implicit 1/2"] {
            let (x, rises) = by(Case::Oscillator(num(h04, "setup/a"), b), method);
            assert!(x <= num(h04, "tolerance/max") && !rises, "b = {b:e} by {method}: {x}");
        }
    }
    for (b, method) in [(2.5, "secant"), (100.0, "secant"), (2.5, "newton"), (100.0, "newton")] {
        let (x, rises) = by(Case::Bow(b), method);
        assert!(x <= 1.0 && !rises, "a bow, b = {b} by {method}: {x}");
    }

    // a bow beyond its limit: the position stays within what its largest force moves it in a tick, over √a; far beyond,
    // the bar moves further and further, by no more than that each tick
    let far = |b: f64| match played(Case::Bow(b), "ca") {
        Outcome::Largest(x, rises) => (x / (b / 0.5f64.exp() / 0.1f64.sqrt()), rises),
        other => panic!("b = {b}: {other:?}"),
    };
    let (steep, steeper) = (far(2.5), far(100.0));
    within("a bow, b = 2.5", steep.0, 0.1);
    assert!(!steep.1 && steeper.1 && steeper.0 > 1.0, "{steeper:?}");
    within("a bow, b = 100, per tick", steeper.0 / 48_000.0, 1.0);

    // at a = 4.5 a blow may take as much energy as the one before made
    let Outcome::Energy(worst, _) = played(Case::Contact(4.5), "ca") else { panic!("a = 4.5") };
    assert!(worst > 1.0, "{worst}");
    for a in [3.0, 1e8, 1e16] {
        assert!(matches!(played(Case::Contact(a), "ca"), Outcome::Made(..)), "a = {a:e}");
    }
    for (a, most) in [(1.0, 1e-12), (3.0, 1e-12), (4.5, 1e-12), (1e8, 1e-9), (1e16, 1e-5)] {
        for (method, most) in [("stable", most), ("stable3d", 1e-12)] {
            let Outcome::Energy(worst, _) = played(Case::Contact(a), method) else { panic!("{method}, a = {a:e}") };
            within(&format!("contact {method}, a = {a:e}"), worst, most);
        }
    }

    for b in [0.0, 0.1] {
        let Outcome::Energy(worst, moment) = played(Case::Ratio(1e6, b), "ca") else { panic!("a pair") };
        within(&format!("mass ratio 1e6, b = {b}, energy"), worst, 1e-14);
        within(&format!("mass ratio 1e6, b = {b}, momentum"), moment, 1e-14);
    }
    let Outcome::Energy(worst, _) = played(Case::Undamped, "ca") else { panic!("a string") };
    within("a string without damping", worst, 2e-13);
    for b in [1e-3, 0.5] {
        let Outcome::Denormal(ticks, gone) = played(Case::Dead(b), "ca") else { panic!("a resonator") };
        assert!(gone && ticks < 1024, "H06 b = {b}: {ticks}");
    }
    let Outcome::Astray(by) = played(Case::Flight, "ca") else { panic!("a flight") };
    // each addition errs by at most half a unit in the last place
    within("ten seconds of free flight", by, 0.5 * f64::EPSILON * Case::Flight.ticks()[1] as f64);
}

#[test]
fn nothing_that_is_no_number_comes_in() {
    for (name, what, try_it) in DOORS {
        let tried = try_it();
        assert!(tried.through.is_empty() && tried.tried >= 6, "{name}: {:?}", tried.through);
        let row = entry_point(name, what, &tried);
        // the row of a new kind is written by `UPDATE`, since nothing else on the page depends on it
        if std::env::var_os("UPDATE").is_some() {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/measured/atlas.md");
            let page = std::fs::read_to_string(path).expect("the page");
            let head = format!("| {name} | ");
            let lines: Vec<&str> = page.lines().map(|l| if l.starts_with(&head) { row.as_str() } else { l }).collect();
            std::fs::write(path, lines.join("\n") + "\n").expect("writable");
            continue;
        }
        assert!(PAGE.contains(&row), "{name}: docs/measured/atlas.md does not have {row}; run this test with UPDATE=1");
    }
}

/// The page has a section and a picture for every map, no contradiction, and the rows that the engine gives today.
#[test]
fn the_page_of_the_atlas_holds() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/measured/atlas");
    let drawn: BTreeSet<String> = std::fs::read_dir(folder)
        .expect("docs/measured/atlas")
        .map(|f| f.expect("readable").file_name().to_string_lossy().trim_end_matches(".svg").to_string())
        .collect();
    assert_eq!(drawn, MAPS.iter().map(|m| m.name.to_string()).collect());
    for map in MAPS {
        assert!(PAGE.contains(&format!("### {}\n", map.title)), "{}", map.name);
        let picture = std::fs::read_to_string(format!("{folder}/{}.svg", map.name)).expect("a picture");
        assert!(picture.contains("contradicts theory: 0<"), "{}", map.name);
    }
    assert_eq!(PAGE.matches("**0 contradict theory**").count(), MAPS.len());
    for case in CASES {
        let [page, here] = case.ticks();
        if page == here {
            assert!(PAGE.contains(&row(case, 1)), "{}", row(case, 1));
        } else {
            assert!(PAGE.contains(&format!("| {} |", case.name())), "{}", case.name());
        }
    }
    let map = &MAPS[0];
    assert!(svg::draw(map, &map.play(4, 3)).matches("<rect").count() > 6);
}
