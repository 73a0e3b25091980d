//! Time of one tick, by scene, kernel class and precision, and the cost of the energy ledger. Throughput is in modules
//! (MAT or LIA), so criterion prints modules per second; only ratios within one run count.
#![allow(missing_docs)]

use ca_benches::{catalog, compiled, mesh, model, random, scene, string};
use ca_compile::{KernelClass, Options, load};
use ca_core::{Precision, tick};
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
            let scene = compiled(&model, kernel, energy);
            let mut state = scene.state();
            g.throughput(Throughput::Elements((scene.counts.n_mat + scene.counts.n_lia) as u64));
            g.bench_function(case, |b| b.iter(|| tick(&scene, &mut state)));
        }
        g.finish();
    }
}

/// The same scenes in double and in single precision.
fn precision(c: &mut Criterion) {
    for (name, text) in [("string 1000", string(1000)), ("mesh 30x30", mesh(30))] {
        let mut g = c.benchmark_group(name);
        let scene = scene(&text);
        let mut state = scene.state();
        g.throughput(Throughput::Elements((scene.counts.n_mat + scene.counts.n_lia) as u64));
        g.bench_function("double", |b| b.iter(|| tick(&scene, &mut state)));
        let options = Options { precision: Precision::Single, ..Options::default() };
        let scene = load(&text, "bench.ca.toml", &catalog(), &options).1.expect("the bench compiles").scene;
        let scene = ca_accuracy::single(&scene).expect("all laws are known");
        let mut state = scene.state();
        g.bench_function("single", |b| b.iter(|| tick(&scene, &mut state)));
        g.finish();
    }
}

criterion_group!(benches, step, precision);
criterion_main!(benches);
