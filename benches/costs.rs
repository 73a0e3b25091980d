//! Cost of each guard, check and method: instructions, counted by valgrind and so independent of the load on the
//! machine, and ns, with and without in turn.
//!
//! The bench counts by running itself under `valgrind --tool=callgrind`, one process per core. Each run has two
//! lengths, and the difference counts. Without valgrind it says so and counts nothing. It fails if a scene pays for
//! something that it does not use. It prints the page; with `UPDATE=1` it writes the page to `docs/measured/costs.md`.

use ca_benches::costs::page::{Price, page};
use ca_benches::costs::{CostRow, Run, rows};
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Ticks of the two runs whose difference counts: whole frames, and multiples of the 1024 ticks between periodic tasks.
const FEW: u32 = 1024;
const MANY: u32 = 9 * FEW;
/// The same in frames of a device, each of many ticks.
const FRAMES: u32 = 256;
const MORE: u32 = 5 * FRAMES;

fn lengths(run: &Run) -> [u32; 2] {
    if run.is_hand() { [FRAMES, MORE] } else { [FEW, MANY] }
}

fn runs(rows: &[CostRow]) -> Vec<Run> {
    let mut all = Vec::new();
    for run in rows.iter().flat_map(|r| [Some(r.plain.clone()), Some(r.used.clone()), r.unheard()]).flatten() {
        if !all.contains(&run) {
            all.push(run);
        }
    }
    all
}

/// Returns the instructions of run `i` with this length.
fn counted(i: usize, length: u32) -> Option<u64> {
    let out = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .env("CA_COSTS", format!("{i} {length}"))
        .output()
        .ok()?;
    let reported = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.success(), "run {i}: {reported}");
    reported.lines().find_map(|l| l.split("Collected : ").nth(1)).and_then(|n| n.trim().parse().ok())
}

/// Returns the instructions per tick or frame of each run; `None` without valgrind.
fn counts(runs: &[Run]) -> Option<Vec<f64>> {
    Command::new("valgrind").arg("--version").output().ok()?;
    let (next, all) = (AtomicUsize::new(0), Mutex::new(vec![None; runs.len()]));
    let work = || {
        while let Some((i, run)) = Some(next.fetch_add(1, Relaxed)).and_then(|i| Some((i, runs.get(i)?))) {
            let [few, many] = lengths(run);
            let each = counted(i, few).zip(counted(i, many)).map(|(a, b)| (b - a) as f64 / f64::from(many - few));
            all.lock().unwrap_or_else(PoisonError::into_inner)[i] = each;
        }
    };
    std::thread::scope(|s| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            s.spawn(work);
        }
    });
    all.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect()
}

/// Returns the ns per tick or frame of the row with its thing, less those without: the best of each, in turn.
fn time(row: &CostRow) -> f64 {
    const TURNS: usize = 32;
    let n = lengths(&row.used)[0];
    let mut best = [f64::INFINITY; 2];
    for _ in 0..TURNS {
        for (best, run) in best.iter_mut().zip([&row.plain, &row.used]) {
            let mut play = run.player();
            play(n / 4);
            let begin = Instant::now();
            play(n);
            *best = best.min(begin.elapsed().as_nanos() as f64 / f64::from(n));
        }
    }
    best[1] - best[0]
}

fn main() -> ExitCode {
    let rows = rows();
    let runs = runs(&rows);
    if let Ok(run) = std::env::var("CA_COSTS") {
        let mut numbers = run.split(' ').filter_map(|n| n.parse::<u32>().ok());
        let (i, length) = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
        runs[i as usize].player()(length);
        return ExitCode::SUCCESS;
    }
    // `cargo test --benches` only checks that it runs
    if !std::env::args().any(|a| a == "--bench") {
        for run in &runs {
            run.player()(16);
        }
        return ExitCode::SUCCESS;
    }
    let mut failed = false;
    for row in &rows {
        if let Err(why) = row.nothing() {
            println!("{}, {}: a scene without it has something of it: {why}", row.thing, row.with);
            failed = true;
        }
    }
    let Some(counts) = counts(&runs) else {
        println!("instructions are counted by valgrind, which is not at hand");
        return if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS };
    };
    let count = |run: &Run| runs.iter().position(|r| r == run).map_or(f64::NAN, |i| counts[i]);
    let price = |row: &CostRow| Price {
        instructions: (count(&row.used) - count(&row.plain)) / row.modules,
        ns: time(row) / row.modules,
        unheard: row.unheard().map(|run| count(&run) - count(&row.plain)),
    };
    let prices: Vec<Price> = rows.iter().map(price).collect();
    let text = page(&rows, &prices, &ca_benches::machine());
    println!("{text}");
    let most = prices.iter().filter_map(|p| p.unheard).fold(0.0, |m: f64, n| m.max(n.abs()));
    println!("The most a scene pays for what nothing hears: {most:.4} instructions per tick.");
    for (row, price) in rows.iter().zip(&prices).filter(|(_, price)| price.is_paid_by_others()) {
        println!("{}, {}: {} in a scene without it", row.thing, row.with, price.unheard.unwrap_or(0.0));
        failed = true;
    }
    if failed {
        return ExitCode::FAILURE;
    }
    if std::env::var_os("UPDATE").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/measured/costs.md");
        std::fs::write(path, text).expect("the page can be written");
    }
    ExitCode::SUCCESS
}
