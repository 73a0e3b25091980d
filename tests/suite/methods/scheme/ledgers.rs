//! Energy: none is created, the ledgers balance, and they name the module that makes energy.

use super::test_models::{FS, string};
use crate::play::{PI, audited, case, mat, mats, num, off, within};
use ca_core::tick;

#[test]
fn a09_nothing_is_created_in_ten_seconds() {
    let c = case("A09");
    let scene = audited(&string(40, 1e-3, 0.9 * 1e-3 * FS * FS, 0.0));
    let masses = mats(&scene, "s");
    let mut s = scene.state();
    for (i, p) in masses.iter().enumerate() {
        s.x[*p] = 1e-3 * ((i + 1) as f64 * PI / 41.0).sin();
    }
    let (mut h0, mut drift) = (0.0, 0.0f64);
    for n in 0..num(c, "setup/steps") as usize {
        tick(&scene, &mut s);
        let h = s.ledger.as_ref().expect("a ledger").h;
        if n == 0 {
            h0 = h;
        }
        drift = drift.max(off(h, h0));
    }
    assert!(h0 > 0.0);
    within("A09 drift", drift, num(c, "tolerance/drift_rel"));
    let k = 0.9 * 1e-3 * FS * FS;
    let mut by_hand = 0.0;
    let ends: Vec<f64> = std::iter::once(0.0).chain(masses.iter().map(|p| s.x[*p])).chain([0.0]).collect();
    let before: Vec<f64> = std::iter::once(0.0).chain(masses.iter().map(|p| s.x[*p] - s.d[*p])).chain([0.0]).collect();
    for i in 0..=40 {
        by_hand += 0.5 * k * (ends[i + 1] - ends[i]) * (before[i + 1] - before[i]);
    }
    by_hand += masses.iter().map(|p| 0.5e-3 * (s.d[*p] * FS).powi(2)).sum::<f64>();
    within("A09 energy by hand", off(by_hand, h0), num(c, "tolerance/drift_rel"));
}

#[test]
fn a10_the_ledger_balances_with_dampers_and_a_force() {
    let c = case("A10");
    let text = string(40, 1e-3, 0.45 * 1e-3 * FS * FS, 0.01 * 1e-3 * FS) + "[ENF]\npush = { to = \"s[13]\" }\n";
    let scene = audited(&text);
    let mut s = scene.state();
    let steps = num(c, "setup/steps") as usize;
    for n in 0..steps {
        s.input[0] = if n < steps / 4 { (0.05 * n as f64).sin() } else { 0.0 };
        tick(&scene, &mut s);
    }
    let ledger = s.ledger.as_ref().expect("a ledger");
    let b = ledger.balance();
    assert!(b.work > 0.0 && b.lost > 0.99 * b.work && b.scheme_error == 0.0, "{b:?}");
    within("A10 one sample", ledger.extremes.worst / b.peak, num(c, "tolerance/residual_rel"));
    within("A10 cumulative", b.residual.abs() / b.peak, num(c, "tolerance/cumulative_rel"));
}

/// The network of A17 at one sample per second, so that T = 1.
const CULPRIT: &str = r#"
[rate]
sound = 1
[SOL]
wall = {}
[MAS]
low = { m = 1, dx0 = 1.3 }
high = { m = 1, dx0 = 3 }
[RES]
spring = { between = ["low", "high"], k = 0.2, l0 = 1.5 }
[BUT]
contact = { between = ["wall", "low"], k = 0.5, d = 1.2 }
[CUB]
cubic = { between = ["wall", "high"], k3 = 0.05, l0 = 3 }
[SOX]
out = { from = "low" }
"#;

#[test]
fn a17_the_ledger_names_who_makes_energy() {
    let c = case("A17");
    let scene = audited(CULPRIT);
    let mut s = scene.state();
    (s.d[mat(&scene, "low")], s.d[mat(&scene, "high")]) = (-0.4, 0.1);
    tick(&scene, &mut s);
    tick(&scene, &mut s);
    let first = s.ledger.clone().expect("a ledger").balance();
    within("A17 energy after the first tick", off(first.h, num(c, "values/H1")), 1e-6);
    for _ in 2..=num(c, "setup/steps") as usize {
        tick(&scene, &mut s);
    }
    let ledger = s.ledger.as_ref().expect("a ledger");
    let b = ledger.balance();
    let tolerance = num(c, "tolerance/closure_abs");
    within("A17 closure", b.residual.abs(), tolerance);
    within(
        "A17 change is what the links made",
        (b.h - first.h - (b.scheme_error - first.scheme_error)).abs(),
        tolerance,
    );
    let (largest_error, made) = ledger.largest_error().expect("someone makes energy");
    assert_eq!(scene.audited_name(largest_error).as_deref(), Some("contact"));
    assert!(made > 0.5 * b.scheme_error && b.scheme_error > 0.1, "{b:?}");
    // the linear spring balances exactly, by theorem
    let spring =
        (0..scene.counts.n_lia).find(|i| scene.audited_name(*i).as_deref() == Some("spring")).expect("the spring");
    assert_eq!(ledger.scheme_error[spring], num(c, "values/spring"));
}
