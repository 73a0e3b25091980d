//! Very many modules: the cost of a tick and of loading, in processor time and memory a module, with what is expected.
//!
//! Prints a page; with `UPDATE=1` writes it to `docs/measured/large.md`. Bytes are counted as requested from the
//! allocator, because the memory from the system varies from run to run.
#![allow(missing_docs)]

use ca_accuracy::timing::processor;
use ca_benches::{at_most, by_hand, catalog, machine, publish, string};
use ca_compile::{Options, compile};
use ca_core::{Scene, process};
use ca_model::read::read;
use counting::{AllocCounts, taken};
use std::fmt::Write as _;

#[path = "../tests/alloc/counting.rs"]
mod counting;

/// Modules of the strings played, and the largest time of each in a tick \[ns\].
const STRINGS: [(usize, Option<f64>); 7] = [
    (100, None),
    (1000, None),
    (10_000, None),
    (30_000, None),
    (100_000, Some(0.22)),
    (300_000, None),
    (1_000_000, Some(0.38)),
];

/// Ticks of a block, as in most programs.
const BLOCK: usize = 64;

const HEAD: &str = "# Very many modules

Made by `UPDATE=1 cargo bench -p ca-benches --bench large`: do not edit.

Each limit is in brackets, with the result of its test. Times are processor time of one thread, the least of several
rounds; bytes are requests to the allocator. ns are for one machine; `ca bench --curve --page bench.html` draws the
same curve for yours, beside the limits of its caches and its memory.
";

const SHORT: &str = "
Reasons for values beyond the limits, from samples of the processor (`perf record` of this bench):

- *Strings of 10^5 modules and more.* Positions, motions and the numbers of each link and mass no longer fit into the
  second-level cache, and each is read once per tick. Storing numbers once for a run of equal modules would fix it.
- *Compiling one line.* No pass dominates: the network, its layout, the coefficients, the certificate and the start
  each process all modules once, in tables larger than the second-level cache. One line could stay one line up to the
  layout, but every pass would need a second implementation.
- *One by one.* Each module is read into a tree of the TOML library, and then into a model, before it is compiled:
  many allocations per module, and no function of them dominates. The model stays in memory while it is compiled, for
  the positions of findings. An event-based reader, without the tree, would fix it.
";

/// Processor time of a stage, and its use of the allocator.
struct Stage {
    ms: f64,
    taken: AllocCounts,
}

fn stage<T>(f: impl FnOnce() -> T) -> (T, Stage) {
    let begin = processor();
    let (done, taken) = taken(f);
    (done, Stage { ms: processor().saturating_sub(begin).as_secs_f64() * 1e3, taken })
}

/// Loads the scene of a text, and measures reading and compiling.
fn load(text: &str) -> (Scene, [Stage; 2]) {
    let catalog = catalog();
    let ((model, findings), reading) = stage(|| read(text, "bench.ca.toml", &catalog));
    assert!(!findings.has_errors(), "{findings}");
    let (scene, compiling) =
        stage(|| compile(&model, &catalog, &Options::default()).expect("the bench compiles").scene);
    (scene, [reading, compiling])
}

fn modules(scene: &Scene) -> usize {
    scene.mats() + scene.lias()
}

/// Returns the ns a module and tick, the least of `rounds` that play `in_all` modules in total.
fn played(scene: &Scene, rounds: usize, in_all: usize) -> f64 {
    let blocks = (in_all / modules(scene)).div_ceil(BLOCK).max(1);
    let (mut s, mut heard) = (scene.state(), vec![0.0; BLOCK * scene.counts.n_out]);
    let mut round = || {
        let begin = processor();
        (0..blocks).for_each(|_| assert!(process(scene, &mut s, &mut heard)));
        processor().saturating_sub(begin).as_secs_f64() * 1e9 / (blocks * BLOCK * modules(scene)) as f64
    };
    round();
    (0..rounds).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn main() {
    // `cargo test --benches` only checks that it runs
    let long = std::env::args().any(|a| a == "--bench");
    let (rounds, part) = if long { (7, 1) } else { (1, 1000) };
    let mut page = format!("{HEAD}\nThe machine of this page is {}.\n", machine());

    page += "\n## A string in a tick\n\n| modules | ns a module |\n|---|---|\n";
    for (n, most) in STRINGS {
        // a mass and a link each, plus two ends and a link
        let (scene, _) = load(&string((n / part).max(8) / 2 - 2));
        let ns = played(&scene, rounds, 100_000_000 / part);
        let _ = writeln!(page, "| {} | {} |", modules(&scene), at_most(ns, 3, most));
    }

    page += "\n## Loading\n\n| model | stage | ms | ns a module | allocations a module | most bytes a module | bytes kept a module |\n|---|---|---|---|---|---|---|\n";
    let mut totals = String::new();
    for (name, text, most_ms, most_bytes, most_all) in [
        ("one line", string(50_000 / part), Some(20.0), Some(100.0), None),
        ("one by one", by_hand(150_000 / part), Some(1000.0), None, Some(200.0)),
    ] {
        let mut best: Option<([Stage; 2], usize)> = None;
        for _ in 0..rounds {
            let (scene, stages) = load(&text);
            if best.as_ref().is_none_or(|(b, _)| b[0].ms + b[1].ms > stages[0].ms + stages[1].ms) {
                best = Some((stages, modules(&scene)));
            }
        }
        let Some((stages, modules)) = best else { continue };
        for (what, s) in ["read", "compile"].into_iter().zip(&stages) {
            let per = |v: u64| v as f64 / modules as f64;
            let (ns, calls) = (s.ms * 1e6 / modules as f64, per(s.taken.calls));
            let (peak, kept) = (per(s.taken.peak), per(s.taken.kept));
            let kept = if what == "compile" { at_most(kept, 0, most_bytes) } else { format!("{kept:.0}") };
            let _ = writeln!(
                page,
                "| {modules} modules, {name} | {what} | {:.1} | {ns:.0} | {calls:.2} | {peak:.0} | {kept} |",
                s.ms
            );
        }
        let [ms, mb] = [
            stages.iter().map(|s| s.ms).sum::<f64>(),
            // the model is kept while it is compiled
            (stages[0].taken.kept + stages[1].taken.peak) as f64 / 1e6,
        ];
        let _ = writeln!(
            totals,
            "| {modules} modules, {name} | {} | {} |",
            at_most(ms, 0, most_ms),
            at_most(mb, 0, most_all)
        );
    }
    let _ = write!(page, "\n| model | in all [ms] | most memory [MB] |\n|---|---|---|\n{totals}{SHORT}");
    publish("large", &page, long);
}
