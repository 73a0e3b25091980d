//! What very many modules cost to load: processor time and memory a module, read and compiled. The requirement: 10^5 modules
//! of one line in 20 ms and in 100 bytes each, 3·10^5 written one by one in a second and in 200 MB.
//!
//! Decides to count bytes as they are asked of the allocator: what the system lends changes from run to run.
#![allow(missing_docs)]

use ca_benches::{by_hand, catalog, string};
use ca_compile::{Options, compile};
use ca_lab::timing::processor;
use ca_model::read::read;
use counting::{Taken, taken};

#[path = "../tests/alloc/counting.rs"]
mod counting;

/// What a stage took: processor time, and of the allocator.
struct Stage {
    ms: f64,
    taken: Taken,
}

fn stage<T>(f: impl FnOnce() -> T) -> (T, Stage) {
    let begin = processor();
    let (done, taken) = taken(f);
    (done, Stage { ms: processor().saturating_sub(begin).as_secs_f64() * 1e3, taken })
}

fn main() {
    // `cargo test --benches` asks whether it runs at all
    let long = std::env::args().any(|a| a == "--bench");
    let (rounds, part) = if long { (5, 1) } else { (1, 1000) };
    let only: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let catalog = catalog();
    println!(
        "{:<30} {:<8} {:>9} {:>10} {:>8} {:>8} {:>8}",
        "model", "stage", "ms", "ns/module", "calls", "peak B", "kept B"
    );
    for (name, text) in [("one line", string(50_000 / part)), ("one by one", by_hand(150_000 / part))] {
        if !only.is_empty() && !only.iter().any(|o| o == name) {
            continue;
        }
        let mut best: Option<([Stage; 2], usize)> = None;
        for _ in 0..rounds {
            let ((model, findings), reading) = stage(|| read(&text, "bench.ca.toml", &catalog));
            assert!(!findings.has_errors(), "{findings}");
            let (scene, compiling) =
                stage(|| compile(&model, &catalog, &Options::default()).expect("the bench compiles").scene);
            let modules = scene.mats() + scene.lias();
            if best.as_ref().is_none_or(|(b, _)| b[0].ms + b[1].ms > reading.ms + compiling.ms) {
                best = Some(([reading, compiling], modules));
            }
        }
        let Some((stages, modules)) = best else { continue };
        for (what, s) in ["read", "compile"].into_iter().zip(stages) {
            let per = |v: u64| v as f64 / modules as f64;
            println!(
                "{:<30} {what:<8} {:>9.2} {:>10.0} {:>8.2} {:>8.0} {:>8.0}",
                format!("{modules} modules, {name}"),
                s.ms,
                s.ms * 1e6 / modules as f64,
                per(s.taken.calls),
                per(s.taken.peak),
                per(s.taken.kept)
            );
        }
    }
}
