//! What a second thread brings to one scene (`ca render --threads 2`), by size: time on the wall of a tick by one thread and
//! by two, and how the cut shares the work.
//!
//! Decides on ratios within one round, of which the middle of several counts: a machine with two cores is never quite idle,
//! and the halves wait for each other in each tick.
#![allow(missing_docs)]

use ca_benches::catalog;
use ca_compile::{Options, compile, halves};
use ca_core::Scene;
use ca_core::scene::Halves;
use ca_io::FileError;
use ca_io::perform::Performance;
use ca_model::read::read;
use std::time::Instant;

/// Ticks handed over at a time.
const BLOCK: u64 = 256;

fn mesh(side: usize) -> String {
    format!(
        "[MESH]\nm = {{ nx = {side}, ny = {side}, m = \"1 g\", k = \"50 kN/m\", z = 0.05 }}\n[MAS]\nh = {{ m = \"5 g\", v = 1 }}\n\
         [BUT]\nb = {{ between = [\"h\", \"m[4,3]\"], k = 9e3 }}\n[SOX]\nout = {{ from = \"m[9,9]\" }}\n"
    )
}

/// ns of a tick by one thread, and by two.
fn round(scene: &Scene, two: &Halves, ticks: u64) -> [f64; 2] {
    let begun = || Performance::new(scene, None).expect("no gesture");
    let mut alone = begun();
    let begin = Instant::now();
    (0..ticks).for_each(|_| alone.tick());
    let one = begin.elapsed();
    let begin = Instant::now();
    let played = ca_io::halves::play(begun(), two, None, (ticks, BLOCK), &mut |_, _| Ok::<(), FileError>(()));
    assert!(played.is_ok(), "it plays to its end");
    [one, begin.elapsed()].map(|t| t.as_secs_f64() * 1e9 / ticks as f64)
}

fn main() {
    // `cargo test --benches` asks whether it runs at all
    let long = std::env::args().any(|a| a == "--bench");
    let (rounds, work, sides) =
        if long { (7, 40_000_000, &[20, 50, 100, 200, 400][..]) } else { (1, 10_000, &[20][..]) };
    println!(
        "{:<22} {:>9} {:>14} {:>15} {:>10} {:>8} {:>8}",
        "mesh", "modules", "one, ns/tick", "two, ns/tick", "one ÷ two", "share", "across"
    );
    for side in sides {
        let catalog = catalog();
        let (model, findings) = read(&mesh(*side), "bench.ca.toml", &catalog);
        assert!(!findings.has_errors(), "{findings}");
        let options = Options::default();
        let scene = compile(&model, &catalog, &options).expect("the bench compiles").scene;
        let two = halves(&model, &catalog, &options, &scene).expect("it is cut");
        let modules = scene.mats() + scene.lias();
        let ticks = (work / modules as u64).max(BLOCK);
        let mut all: Vec<[f64; 2]> = (0..rounds).map(|_| round(&scene, &two, ticks)).collect();
        all.sort_by(|a, b| (a[0] / a[1]).total_cmp(&(b[0] / b[1])));
        let [one, both] = all[all.len() / 2];
        println!(
            "{:<22} {modules:>9} {one:>14.0} {both:>15.0} {:>10.2} {:>8.2} {:>8}",
            format!("{side} × {side}"),
            one / both,
            two.share,
            two.across
        );
    }
}
