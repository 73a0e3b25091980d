//! One tick, by scene and kernel class, and what the energy book costs. Throughput is in modules (MAT or LIA), so
//! criterion prints modules per second; only ratios within one run count.
#![allow(missing_docs)]

use ca_benches::{mesh, model, random, scene, string};
use ca_core::{KernelClass, tick};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};

fn step(c: &mut Criterion) {
    let scenes = [
        ("string 50", string(50)),
        ("string 500", string(500)),
        ("mesh 20x20", mesh(20)),
        ("random 500+1000", random(500, 1000)),
    ];
    for (name, text) in scenes {
        let mut g = c.benchmark_group(name);
        let model = model(&text);
        let cases = [
            ("reference", KernelClass::Reference, false),
            ("fast", KernelClass::Fast, false),
            ("fast, energy kept", KernelClass::Fast, true),
        ];
        for (case, kernel, energy) in cases {
            let scene = scene(&model, kernel, energy);
            let mut state = scene.state();
            g.throughput(Throughput::Elements((scene.n_mat + scene.n_lia) as u64));
            g.bench_function(case, |b| b.iter(|| tick(&scene, &mut state)));
        }
        g.finish();
    }
}

criterion_group!(benches, step);
criterion_main!(benches);
