//! Forces of every law: action and reaction, bounds, passivity, and energies.

use crate::play::{Random, mat};
use crate::random_parameters::{Loaded, built, laws, methods, only_resists, pair};
use ca_compile::Options;
use ca_core::tick;
use ca_model::{Entry, Value};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn action_is_reaction(seed in 1u64.., x in -2e-3..2e-3f64, y in -2e-3..2e-3f64, v in -1e-5..1e-5f64) {
        for (kind, way) in methods() {
            let scene = built(&pair(kind, way, &mut Random(seed)), &Options::default());
            let (a, b) = (mat(&scene, "low"), mat(&scene, "high"));
            let mut s = scene.state();
            (s.x[a], s.x[b], s.d[a]) = (x, y, v);
            for _ in 0..200 {
                ca_core::compute_forces(&scene, &mut s);
                // a solved force is rounded at each mass separately
                let tolerance = if scene.layout.implicit.is_some() { 1e-13 * s.f[a].abs() } else { 0.0 };
                prop_assert!((s.f[a] + s.f[b]).abs() <= tolerance, "{}: {} and {}", kind.code, s.f[a], s.f[b]);
                ca_core::integrate(&scene, &mut s);
            }
        }
    }

    /// Work done on a link along a path is stored or becomes heat, up to the jump of the force in one step.
    #[test]
    fn work_is_stored_or_heat(seed in 1u64.., from in -1e-3..1e-3f64, way in -2e-3..2e-3f64) {
        for (kind, _) in laws() {
            let mut l = Loaded::new(kind, &mut Random(seed));
            let n = 20_000;
            let path = |i: i32| from + way * f64::from(i.clamp(0, n)) / f64::from(n);
            l.start(from);
            let held = l.stored(from);
            let (mut work, mut heat, mut scale) = (0.0, 0.0, 0.0f64);
            // the sum errs where the force has a kink within a step, by at most the jump of the force there
            let (mut last, mut bend) = (None, 0.0f64);
            for i in 0..=n {
                let e = [path(i - 1), path(i), path(i + 1)];
                let f = l.force(e[1], e[1] - e[0]);
                work += f * 0.5 * (e[2] - e[0]);
                heat += (l.law.fns.energies.lost)(&l.c, &l.mem, &l.tables, e);
                scale = scale.max((f * way).abs());
                bend = bend.max((f - last.unwrap_or(f)).abs());
                last = Some(f);
            }
            let gain = l.stored(from + way) - held;
            prop_assert!(
                (gain + heat - work).abs() <= 1e-6 * scale + bend * (way / f64::from(n)).abs(),
                "{gain} and {heat} are not {work}\n{}",
                l.named
            );
        }
    }

    /// Over a closed path a link never gives net work, and its reported heat is never negative.
    #[test]
    fn a_cycle_gains_nothing(seed in 1u64.., middle in -5e-4..5e-4f64, swing in 1e-4..2e-3f64) {
        for (kind, _) in laws() {
            let mut l = Loaded::new(kind, &mut Random(seed));
            let n = 20_000;
            let path = |i: i32| middle + swing * (f64::from(i) * std::f64::consts::TAU / f64::from(n)).sin();
            let (mut taken, mut scale) = (0.0, 0.0f64);
            for i in -n..n {
                let e = [path(i - 1), path(i), path(i + 1)];
                let f = l.force(e[1], e[1] - e[0]);
                let heat = (l.law.fns.energies.lost)(&l.c, &l.mem, &l.tables, e);
                prop_assert!(heat >= 0.0, "heat {heat} at {e:?}\n{}", l.named);
                if i >= 0 {
                    let work = f * 0.5 * (e[2] - e[0]);
                    taken += work;
                    scale += work.abs();
                }
            }
            prop_assert!(taken >= -1e-3 * scale, "{taken} of {scale}\n{}", l.named);
        }
    }

    /// No slope exceeds the bound in the certificate; for laws that harden without end, at rest.
    #[test]
    fn bounds_bound(seed in 1u64.., e in -2e-3..2e-3f64, step in 1e-7..1e-4f64, w in -1e-5..1e-5f64) {
        for (kind, _) in laws() {
            let mut l = Loaded::new(kind, &mut Random(seed));
            let bound = (l.law.at_load.bound)(&l.c, &l.tables);
            let (from, to) = (l.law.fns.idle)(&l.c);
            let rest = if !l.law.contact { 0.0 } else if from.is_finite() { from } else { to };
            let e = if bound.hardens { rest } else { e };
            // a law with memory restarts at `e` each time; a release during the step has no meaningful slope
            let mut rise = |step: f64| {
                let f = [e, e + step].map(|x| {
                    l.start(e);
                    l.force(x, 0.0)
                });
                // the step as rounded by the addition
                let step = (e + step) - e;
                if l.law.mem > 0 && f[1] == 0.0 { 0.0 } else { ((f[1] - f[0]) / step).abs() }
            };
            let over = |rise: f64| rise - bound.k * (1.0 + 1e-6) - 1e-6;
            for step in [step, -step] {
                if bound.hardens {
                    let (near, nearer) = (over(rise(1e-5 * step)), over(rise(1e-9 * step)));
                    prop_assert!(
                        nearer <= 0.5 * near.max(0.0),
                        "the slope at rest, at the elongation {e}, is {nearer} above `k` = {} of `bound`: rest is 0, and of a \
                         contact (`CONTACT = true`) the end of `idle`\n{}",
                        bound.k,
                        l.named
                    );
                } else {
                    prop_assert!(
                        over(rise(step)) <= 0.0,
                        "the slope {} at the elongation {e} is above `k` = {} of `bound`, which does not say `hardens`\n{}",
                        rise(step),
                        bound.k,
                        l.named
                    );
                }
            }
            let f = [w + 1e-6, w].map(|w| {
                l.start(e);
                l.force(e, w)
            });
            let tug = (f[0] - f[1]).abs() / 1e-6;
            prop_assert!(tug <= bound.z * (1.0 + 1e-6) + 1e-6, "{tug} above {}\n{}", bound.z, l.named);
            prop_assert!(!bound.active, "a table that resists is not active\n{}", l.named);
        }
    }

    /// With the ledger, every law balances and heat is never negative. Linear and implicit laws make no energy, and
    /// purely resisting laws never accelerate a mass.
    #[test]
    fn ledgers_balance(seed in 1u64.., x in -1e-3..1e-3f64, v in -0.2..0.2f64) {
        for (kind, way) in methods() {
            let mut m = pair(kind, way, &mut Random(seed));
            m.add("SOL", "ground", []);
            m.add("RES", "tie", [Entry::new("between", Value::from(vec!["ground", "low"])), Entry::new("k", 1e4)]);
            let scene = built(&m, &Options { energy: true, ..Options::default() });
            let mut s = scene.state();
            let resists = only_resists(&scene);
            let high = mat(&scene, "high");
            (s.x[high], s.d[high]) = (x, v * scene.rates.sample_dt);
            let (mut before, mut force, mut far) = (0.0, 0.0f64, 0.0f64);
            for n in 0..2000 {
                tick(&scene, &mut s);
                let tie = 1e4 * s.x[mat(&scene, "low")].abs();
                force = s.links.tap.iter().fold(force.max(tie), |m, f| m.max(f.abs()));
                far = s.x.iter().fold(far, |m, x| m.max(x.abs()));
                let ledger = s.ledger.as_ref().expect("a ledger");
                prop_assert!(ledger.lost.iter().all(|l| *l >= 0.0), "{}", kind.code);
                if n > 0 && resists {
                    let most = before + ledger.scheme_error.iter().sum::<f64>().abs() + 1e-12 * ledger.extremes.peak;
                    prop_assert!(ledger.h <= most, "{} {way}, tick {n}: {} J after {before} J", kind.code, ledger.h);
                }
                before = ledger.h;
            }
            let b = s.ledger.as_ref().expect("a ledger").balance();
            // a large force far from rest with little stored energy: rounding of positions, a random walk of 2000 steps
            let places = (2000.0f64 / 12.0).sqrt() * f64::EPSILON * force * far;
            prop_assert!(b.residual.abs() <= 1e-12 * b.peak + places, "{} {way}: {b:?}", kind.code);
            prop_assert!(way == "ca" || b.scheme_error <= 1e-12 * b.peak + places, "{} {way}: {b:?}", kind.code);
            prop_assert!(b.scheme_error == 0.0 || scene.passes.forces.iter().any(|o| o.law.is_some_and(|l| !l.linear)));
        }
    }
}
