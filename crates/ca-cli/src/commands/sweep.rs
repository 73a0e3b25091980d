//! `ca sweep`: a plan into a folder of sounds and rows.
//!
//! Decides that threads share nothing but the number of the next chunk, and that the manifest is written by whoever finds
//! all chunks there.

use crate::args::SweepArgs;
use crate::commands::render::{listen, stopped};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_model::quantity::short;
use ca_sweep::folder::Folder;
use ca_sweep::plan::{self, Plan};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

/// Runs the command.
pub fn run(args: &SweepArgs) -> Outcome {
    listen();
    let plan = plan::read(&args.plan)?;
    if args.dry_run {
        return dry(&plan);
    }
    let path = args.output.as_ref().unwrap_or(&plan.folder);
    let folder = Folder::open(path, &plan.sweep, plan.audio, plan.chunk)?;
    let (part, parts) = args.shard.unwrap_or((1, 1));
    let own = (0..folder.chunks()).filter(|c| c % parts == part - 1);
    let chunks: Vec<u64> = own.filter(|c| !folder.has(*c)).collect();
    let size = |c: &u64| folder.span(*c).1 - folder.span(*c).0;
    let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = args.threads.map_or_else(cores, usize::from).min(chunks.len().max(1));
    let begin = Instant::now();
    let counts = played(&plan, &folder, &chunks, threads).map_err(|e| match e {
        Failure::Interrupted(_) => Failure::Interrupted(left(&plan, &folder, path)),
        other => other,
    })?;
    let wall = begin.elapsed().as_secs_f64();
    let whole = folder.gather(&plan.sweep)?.is_some();

    let runs: u64 = chunks.iter().map(size).sum();
    let mut out = std::io::stdout().lock();
    if args.json {
        let all = json!({
            "folder": path, "runs": plan.sweep.runs(), "played": runs, "seconds": wall, "threads": threads,
            "status": counts, "complete": whole,
        });
        writeln!(out, "{all:#}")?;
        return Ok(Ended::Well);
    }
    let there = plan.sweep.runs();
    let by = if threads == 1 { "1 thread".into() } else { format!("{threads} threads") };
    writeln!(out, "{}  {runs} of {there} runs in {wall:.2} s, {by}", path.display())?;
    if runs > 0 {
        let list: Vec<String> = counts.iter().map(|(status, n)| format!("{n} {status}")).collect();
        writeln!(
            out,
            "  {}; {} ms a run and thread",
            list.join(", "),
            short(1e3 * wall * threads as f64 / runs as f64)
        )?;
    }
    let what = if whole { "all runs are there: `manifest.parquet`" } else { "other parts are not there yet" };
    writeln!(out, "  {what}")?;
    Ok(Ended::Well)
}

/// Plays these chunks, and says how many runs ended how.
fn played(plan: &Plan, folder: &Folder, chunks: &[u64], threads: usize) -> Result<BTreeMap<String, u64>, Failure> {
    let bar = term::progress(chunks.iter().map(|c| folder.span(*c).1 - folder.span(*c).0).sum());
    let next = AtomicUsize::new(0);
    let counts: Mutex<BTreeMap<String, u64>> = Mutex::default();
    let failed: Mutex<Option<ca_lab::Failure>> = Mutex::default();
    let work = || {
        let mut own: BTreeMap<String, u64> = BTreeMap::new();
        while let Some(chunk) = chunks.get(next.fetch_add(1, Relaxed)) {
            let done = folder.fill(&plan.sweep, *chunk, &mut |status| {
                if let Some(status) = status {
                    *own.entry(status.into()).or_default() += 1;
                    bar.inc(1);
                }
                !stopped()
            });
            if let Err(e) = done {
                // one failure ends them all: the others would meet it too
                next.store(chunks.len(), Relaxed);
                *failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(e);
            }
        }
        let mut all = counts.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        for (status, n) in own {
            *all.entry(status).or_default() += n;
        }
    };
    std::thread::scope(|s| {
        for _ in 1..threads {
            s.spawn(work);
        }
        work();
    });
    bar.finish_and_clear();
    match failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
        Some(e) => Err(e.into()),
        None => Ok(counts.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)),
    }
}

/// The message of a sweep that Ctrl-C ended: the runs that are kept, and the command for the others.
fn left(plan: &Plan, folder: &Folder, path: &Path) -> String {
    let there: u64 = (0..folder.chunks()).filter(|c| folder.has(*c)).map(|c| folder.span(c).1 - folder.span(c).0).sum();
    let all = plan.sweep.runs();
    let kept = format!("{there} of {all} runs are in `{}` and stay there", path.display());
    format!("interrupted: {kept}; the same command goes on with the others")
}

/// What would be played, and how long it takes.
fn dry(plan: &Plan) -> Outcome {
    let sweep = &plan.sweep;
    let (row, _) = sweep.run(0, &mut || true)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}  {} runs in {} chunks", plan.folder.display(), sweep.runs(), sweep.runs().div_ceil(plan.chunk))?;
    for (axis, value) in sweep.ask().axes.iter().zip(&row.values) {
        writeln!(out, "  {} = {} in the first", axis.name, axis.shown(value))?;
    }
    let time = |runs: f64| term::time(row.run_time * runs);
    writeln!(
        out,
        "  the first is {} and took {}; all of them {} by one thread",
        row.status,
        time(1.0),
        time(sweep.runs() as f64)
    )?;
    if !row.message.is_empty() {
        writeln!(out, "  {}", row.message)?;
    }
    Ok(Ended::Well)
}
