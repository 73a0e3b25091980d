//! Random networks and texts give a diagnostic or a scene, never a panic, and proven scenes stay finite.

use crate::play::Random;
use ca_compile::{KernelClass, Options, compile};
use ca_core::{Level, tick};
use ca_model::{Entry, Model, Value, read, render};
use ca_tests::{catalog, texts};
use proptest::prelude::*;

/// Masses, cells and fixed points with random links, linear only unless `any`.
fn network(seed: u64, any: bool) -> Model {
    let mut rng = Random(seed);
    let mut pick = |n: usize| (((rng.uniform() + 1.0) * 0.5 * n as f64) as usize).min(n - 1);
    let n = 2 + pick(10);
    let mut m = Model::default();
    // stiffness over mass from far below to above the limit at this rate
    let stiff = [10.0, 1e3, 1e5, 1e6, 4e6][pick(5)];
    for i in 0..n {
        let mass = [1e-3, 2e-3, 0.1, 1.0][pick(4)];
        let own = [Entry::new("m", mass), Entry::new("dx0", 1e-3 * (pick(3) as f64 - 1.0))];
        match pick(5) {
            0 => m.add("SOL", &format!("n{i}"), []),
            1 => m.add(
                "CEL",
                &format!("n{i}"),
                own.into_iter().chain([Entry::new("k", stiff * pick(3) as f64), Entry::new("z", 0.1 * pick(3) as f64)]),
            ),
            _ => m.add("MAS", &format!("n{i}"), own),
        };
    }
    for i in 0..n + pick(2 * n) {
        let ends = vec![format!("n{}", pick(n)), format!("n{}", pick(n))];
        let mut own =
            vec![Entry::new("between", Value::from(ends)), Entry::new("k", stiff * (0.1 + pick(10) as f64 * 0.1))];
        own.push(Entry::new("z", [0.0, 1e-3, 0.1, 2.0][pick(4)]));
        let kind = if any { ["REF", "BUT", "CUB", "REF"][pick(4)] } else { "REF" };
        match kind {
            "CUB" => own.push(Entry::new("k3", 1e9 * pick(3) as f64)),
            "BUT" => own.push(Entry::new("d", 1e-4 * (pick(5) as f64 - 2.0))),
            _ => {}
        }
        m.add(kind, &format!("l{i}"), own);
    }
    m.add("SOX", "out", [Entry::new("from", "n0")]);
    if pick(4) > 0 {
        m.add("SOX", "other", [Entry::new("from", format!("n{}", n - 1).as_str())]);
    }
    m
}

fn survives(text: &str) {
    let catalog = ca_tests::catalog();
    let (model, diags) = read::read(text, "chance", &catalog);
    render::text(&diags, &model, false);
    match compile(&model, &catalog, &Options { energy: true, ..Options::default() }) {
        Ok(scene) if scene.counts.n_mat + scene.counts.n_lia < 5000 => {
            let mut s = scene.state();
            (0..20).for_each(|_| tick(&scene, &mut s));
            render::text(&scene.findings, &model, false);
        }
        Ok(_) => {}
        Err(found) => {
            assert!(found.has_errors());
            render::text(&found, &model, false);
        }
    }
}

#[test]
fn a_finding_never_splits_a_letter() {
    let text = "[SOX]\nout = { from = \"[é\" }\n";
    let (model, _) = read::read(text, "chance", &catalog());
    let found = compile(&model, &catalog(), &Options::default()).expect_err("no module");
    for (span, _) in found.list.iter().flat_map(|d| &d.labels).filter(|l| l.0.is_some()) {
        assert!(text.get(span.start..span.end).is_some(), "{span:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn what_is_proven_stays_bounded(seed in 1u64..) {
        let m = network(seed, false);
        match compile(&m, &catalog(), &Options { energy: true, ..Options::default() }) {
            Err(found) => prop_assert!(found.has_errors()),
            Ok(scene) => {
                let mut s = scene.state();
                let mut least = f64::INFINITY;
                for _ in 0..3000 {
                    tick(&scene, &mut s);
                    if let Some(ledger) = &s.ledger {
                        least = least.min(ledger.h / ledger.extremes.peak.max(1e-300));
                    }
                }
                if scene.certificate.level == Level::Proven {
                    let b = s.ledger.as_ref().expect("a ledger").balance();
                    prop_assert!(s.is_bounded(10.0), "{:?}", scene.certificate);
                    // stable means that the energy is never negative and only falls
                    prop_assert!(least >= -1e-12 && b.h <= b.h0 * (1.0 + 1e-9) + 1e-300, "{b:?}");
                    prop_assert!(b.residual.abs() <= 1e-11 * b.peak, "{b:?}");
                }
                if scene.certificate.level == Level::Unstable {
                    let c = &scene.certificate;
                    prop_assert!((c.lower >= 4.0 || c.exact) && !c.worst.is_empty());
                }
            }
        }
    }

    /// The exact test of docs/numerics.md §1.3 by a dense factorisation; the cheap bounds never contradict it.
    #[test]
    fn the_certificate_never_contradicts_the_exact_test(seed in 1u64..) {
        let m = network(seed, false);
        let Ok(scene) = compile(&m, &catalog(), &Options { kernel: KernelClass::Reference, ..Options::default() }) else { return Ok(()) };
        // S/M = 1 − (T²K + 2TC)/4M from the compiled scene: one tick of x alone gives T²K/M, one of d alone T C/M
        let free: Vec<usize> = (0..scene.counts.n_mat).filter(|i| scene.state().coef[2 * scene.counts.n_mat + i] > 0.0).collect();
        let c: Vec<f64> = free.iter().map(|i| scene.state().coef[2 * scene.counts.n_mat + i]).collect();
        let n = free.len();
        let mut a = vec![vec![0.0; n]; n];
        for (j, p) in free.iter().enumerate() {
            for (moves, weight) in [(false, 1.0), (true, 2.0)] {
                let mut s = scene.state();
                s.x.fill(0.0);
                s.d.fill(0.0);
                if moves { s.d[*p] = 1.0 } else { s.x[*p] = 1.0 }
                tick(&scene, &mut s);
                for (i, q) in free.iter().enumerate() {
                    let kept = if moves && i == j { 1.0 } else { 0.0 };
                    // symmetric: scaled by the roots of the masses
                    a[i][j] += weight * (kept - s.d[*q]) * (c[j] / c[i]).sqrt();
                }
            }
        }
        let definite = |limit: f64| {
            let mut l = vec![vec![0.0; n]; n];
            for i in 0..n {
                for j in 0..=i {
                    let dot: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
                    let s = if i == j { limit } else { 0.0 } - a[i][j] - dot;
                    if i == j {
                        if s <= 0.0 { return false; }
                        l[i][i] = s.sqrt();
                    } else {
                        l[i][j] = s / l[j][j];
                    }
                }
            }
            true
        };
        prop_assert!(definite(scene.certificate.bound * (1.0 + 1e-9) + 1e-9), "λ is above {:?}", scene.certificate);
        if n > 0 && scene.certificate.lower > 0.0 {
            // numbers from a tick are exact to the last place of 1
            prop_assert!(!definite(scene.certificate.lower * (1.0 - 1e-9) - 1e-14), "λ is below {:?}", scene.certificate);
        }
    }

    #[test]
    fn any_network_compiles_or_is_reported_why(seed in 1u64..) {
        let m = network(seed, true);
        if let Ok(scene) = compile(&m, &catalog(), &Options::default()) {
            let mut s = scene.state();
            (0..200).for_each(|_| tick(&scene, &mut s));
            let contacts = scene.passes.forces.iter().any(|o| o.law.is_some_and(|l| !l.linear && l.stage.is_explicit()));
            prop_assert!(!contacts || scene.certificate.level != Level::Proven);
        }
    }

    #[test]
    fn bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        survives(&String::from_utf8_lossy(&bytes));
    }

    #[test]
    fn mutated_models_never_panic(which in any::<prop::sample::Index>(), seed in 1u64.., edits in 1usize..6) {
        const BITS: &[&str] = &["", "0", "-1", "1e308", "nan", "inf", "\"", "[", "]", "{", "}", "=", ".", ",", "@0.5", "[*]", "[-1]",
            "\n", "[MAS]\n", "k", "m = 0", "\"1e-300 kg\"", "99999999", "1e-320", "'", "live = true", "\u{feff}", "é"];
        // large texts are left out, because a mutated count may enlarge them
        let texts: Vec<_> = texts().into_iter().filter(|t| t.1.len() < 6000).collect();
        let mut text = which.get(&texts).1.clone();
        let mut rng = Random(seed);
        let mut pick = |n: usize| (((rng.uniform() + 1.0) * 0.5 * n as f64) as usize).min(n - 1);
        for _ in 0..edits {
            let cuts: Vec<usize> = text.char_indices().map(|c| c.0).collect();
            if cuts.is_empty() { break; }
            let at = cuts[pick(cuts.len())];
            let end = cuts[pick(cuts.len())].clamp(at, (at + 12).min(text.len()));
            if text.is_char_boundary(end) {
                text.replace_range(at..end, BITS[pick(BITS.len())]);
            }
        }
        survives(&text);
    }
}
