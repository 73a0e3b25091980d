//! Contacts between all pairs of grains in a shell: as a module for each pair, as one pass over all pairs, and by a
//! list of neighbours.
//!
//! Only that pass of the tick is timed, on flying grains, each time from the same state. The constants of
//! `ca_core::internal::numeric::VerletList` and the least number of pairs in a set come from here.
//!
//! `… apart` is a set in which nothing touches: its time divided by its pairs is the cost of an idle pair.
#![allow(missing_docs)]

use ca_benches::{compiled, grains, model};
use ca_compile::KernelClass;
use ca_core::{Scene, State, integrate, tick};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use std::time::{Duration, Instant};

/// Ticks before anything is timed, until the grains collide.
const WARM: u64 = 500;

/// Returns the time of the pass of the grains in `ticks` ticks.
fn pass(scene: &Scene, s: &mut State, ticks: u64) -> Duration {
    let hits = scene.passes.forces.iter().rposition(|op| op.law.is_some()).expect("the contact of the grains");
    let mut retired = Duration::ZERO;
    for _ in 0..ticks {
        for (i, op) in scene.passes.reads.iter().chain(scene.passes.summed()).enumerate() {
            let begin = (i == hits + scene.passes.reads.len()).then(Instant::now);
            (op.kernel)(op, scene, s);
            retired += begin.map_or(Duration::ZERO, |b| b.elapsed());
        }
        integrate(scene, s);
    }
    // subtracts the time for reading the clock
    let begin = Instant::now();
    let clock = (0..1000).map(|_| Instant::now().elapsed()).sum::<Duration>();
    retired.saturating_sub(clock.min(begin.elapsed()) * u32::try_from(ticks).unwrap_or(u32::MAX) / 1000)
}

fn contacts(c: &mut Criterion) {
    for (fill, speed) in [(0.1, 0.001), (0.35, 0.001), (0.1, 0.01), (0.35, 0.01), (0.001, 0.0)] {
        let apart = if speed == 0.0 { ", apart" } else { "" };
        let mut g = c.benchmark_group(format!("fill {fill}, {speed} diameters per tick{apart}"));
        g.sample_size(10).warm_up_time(Duration::from_millis(50)).measurement_time(Duration::from_millis(300));
        for n in [3, 4, 6, 8, 16, 32, 64, 128, 256, 512, 1024] {
            let model = model(&grains(n, fill, speed));
            for (method, class, skin) in [
                ("pairs", KernelClass::Reference, 0.0),
                ("set", KernelClass::Fast, 0.0),
                ("list", KernelClass::Fast, 0.5),
                ("list, wider", KernelClass::Fast, 0.75),
                ("list, narrower", KernelClass::Fast, 0.25),
            ] {
                // half a million modules show nothing new
                if class == KernelClass::Reference && n > 512 {
                    continue;
                }
                let scene = compiled(&model, class, false);
                let mut warm = scene.state();
                warm.links.near.iter_mut().for_each(|near| near.skin = skin);
                (0..WARM).for_each(|_| tick(&scene, &mut warm));
                g.bench_function(BenchmarkId::new(method, n), |b| {
                    b.iter_custom(|ticks| pass(&scene, &mut warm.clone(), ticks));
                });
            }
        }
        g.finish();
    }
}

criterion_group!(benches, contacts);
criterion_main!(benches);
