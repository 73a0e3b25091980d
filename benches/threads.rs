//! What a second thread brings to one scene (`ca render --threads 2`), by size: time on the wall of a tick by one thread and
//! by two, and how the cut shares the work. Prints a page; with `UPDATE=1` writes it to `docs/measured/threads.md`.
//!
//! Decides on ratios within one round, of which the middle of several counts: a machine with two cores is never quite idle,
//! and the halves wait for each other in each tick.
#![allow(missing_docs)]

use ca_benches::{catalog, machine, publish};
use ca_compile::{Options, compile, halves};
use ca_core::Scene;
use ca_core::scene::Halves;
use ca_io::FileError;
use ca_io::perform::Performance;
use ca_model::read::read;
use std::fmt::Write as _;
use std::time::Instant;

const HEAD: &str = "# Two threads for one scene

Made by `UPDATE=1 cargo bench -p ca-benches --bench threads`: do not edit.

A mesh that a mass strikes, cut in two as `ca render --threads 2` cuts it: what one thread and what two take for a tick, on
the wall. Both play in turns, and the round with the middle ratio counts. The sound is the same to rounding (link by link, `--kernel reference`, to the bit). *Share* is the larger half's part of the predicted work, *across* how many links join the halves.
In every tick each half waits for the other, so what a second thread brings is that of a core which has nothing else to do: two
processors that are two threads of one core, or that others use too, bring less than two cores of one's own.
";

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
    let mut page = format!("{HEAD}\nThe machine of this page is {}.\n", machine());
    page += "\n| mesh | modules | one [ns a tick] | two [ns a tick] | times as fast | share | across |\n|---|---|---|---|---|---|---|\n";
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
        let _ = writeln!(
            page,
            "| {side} × {side} | {modules} | {one:.0} | {both:.0} | {:.2} | {:.2} | {} |",
            one / both,
            two.share,
            two.across
        );
    }
    publish("threads", &page, long);
}
