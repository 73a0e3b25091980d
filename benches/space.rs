//! Cost per tick of one module in space: a mass, a link, an LPR upon cells, a contact that is closed and one that is
//! open. Each pass runs alone. Throughput is in modules; only ratios within one run count.
#![allow(missing_docs)]

use ca_benches::scene;
use ca_core::internal::op::Op;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::fmt::Write as _;

/// Masses in a ring, each joined to the next.
const N: usize = 256;

fn ring(section: &str, args: &str, onto: bool) -> String {
    let mut t = String::from("[air]\ndim = 3\n[air.MAS]\n");
    for i in 0..N {
        let (s, c) = (i as f64 * std::f64::consts::TAU / N as f64).sin_cos();
        let _ = writeln!(t, "v{i} = {{ m = \"1 g\", x = [{s:?}, {c:?}, 0] }}");
    }
    t += "[CEL]\n";
    for i in 0..N {
        let _ = writeln!(t, "c{i} = {{ m = \"1 g\", k = \"50 kN/m\" }}");
    }
    let _ = writeln!(t, "[{section}]");
    for i in 0..N {
        let next = (i + 1) % N;
        let onto = if onto { format!("onto = [\"c{i}\", \"c{next}\"], ") } else { String::new() };
        let _ = writeln!(t, "l{i} = {{ between = [\"air.v{i}\", \"air.v{next}\"], {onto}{args} }}");
    }
    t + "[SOX]\nout = { from = \"air.v0\", along = \"x\" }\n"
}

fn space(c: &mut Criterion) {
    let mut g = c.benchmark_group("space");
    g.throughput(Throughput::Elements(N as u64));
    let spring = "k = \"10 kN/m\", z = \"1 mN s/m\"";
    let cases = [
        ("link", ring("REF", spring, false)),
        ("LPR", ring("LPR", spring, true)),
        ("contact, pressed", ring("BUT", &format!("{spring}, d = \"1 m\""), false)),
        ("contact, idle", ring("BUT", &format!("{spring}, d = \"1 mm\""), false)),
    ];
    for (i, (name, text)) in cases.iter().enumerate() {
        let scene = scene(text);
        let mut state = scene.state();
        let mut run = |name: &str, op: &Op| {
            assert!(op.n >= N, "{name}: {} modules", op.n);
            g.bench_function(name, |b| b.iter(|| (op.kernel)(op, &scene.layout, &mut state)));
        };
        if i == 0 {
            run("mass", &scene.passes.moves[0]);
        }
        run(name, scene.passes.forces.iter().find(|o| o.law.is_some()).expect("links"));
    }
    g.finish();
}

criterion_group!(benches, space);
criterion_main!(benches);
