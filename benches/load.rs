//! Time from text to a playable scene.
//!
//! Requirements: less than 50 ms to read, recognise and compile a 1000-mass string and a 20 × 30 mesh in the format of
//! MIMS; less than 0.5 s to certify a mesh of 40 000, which is the difference between the two meshes.
#![allow(missing_docs)]

use ca_benches::{by_hand, compiled, mims_mesh, string};
use ca_compile::KernelClass;
use ca_core::Level;
use ca_import::mims;
use ca_model::read::read;
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;

fn load(c: &mut Criterion) {
    let mut g = c.benchmark_group("load");
    let catalog = ca_model::catalog();
    for (name, text) in [("string of 1000, generated", string(1000)), ("string of 1000, by hand", by_hand(1000))] {
        g.bench_function(name, |b| {
            b.iter(|| {
                let (model, _) = read(black_box(&text), "bench.ca.toml", &catalog);
                compiled(&model, KernelClass::Fast, false)
            });
        });
    }
    let ours = mims_mesh();
    g.bench_function("MIMS mesh 20 x 30", |b| {
        b.iter(|| compiled(&mims::import(black_box(&ours), "mesh.mdl").0, KernelClass::Fast, false));
    });
    for (name, k) in [("by the bounds", 0.4999), ("by a factorisation", 0.5)] {
        let text = format!(
            "[rate]\nsound = 1\ngesture = 1\n[MESH]\nm = {{ nx = 200, ny = 200, m = 1, k = {k} }}\n[SOX]\nout = {{ from = \"m[0,0]\" }}\n"
        );
        let (model, _) = read(&text, "bench.ca.toml", &catalog);
        let certificate = compiled(&model, KernelClass::Fast, false).certificate;
        assert_eq!((certificate.level, certificate.exact), (Level::Proven, k == 0.5));
        g.sample_size(10);
        g.bench_function(format!("mesh 200 x 200, certified {name}"), |b| {
            b.iter(|| compiled(black_box(&model), KernelClass::Fast, false));
        });
    }
    // published models, if they are available
    for name in ["20x30mesh", "1000massString"] {
        let path = format!("{}/../../shared/data/mims/{name}.mdl", env!("CARGO_MANIFEST_DIR"));
        if let Ok(text) = std::fs::read_to_string(path) {
            g.bench_function(format!("published {name}"), |b| {
                b.iter(|| compiled(&mims::import(black_box(&text), name).0, KernelClass::Fast, false));
            });
        }
    }
    g.finish();
}

criterion_group!(benches, load);
criterion_main!(benches);
