//! `ca sweep`: plays a plan into a folder of sounds and rows.
//!
//! Threads share only the number of the next chunk. The process that finds all chunks present writes the manifest.

use crate::commands::render::{listen, stopped};
use crate::outcome::{Ended, Failure, Outcome};
use crate::term;
use ca_model::quantity::short;
use ca_sweep::folder::Folder;
use ca_sweep::plan::{self, SweepPlan};
use clap::Args;
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::Instant;

/// Plays a model many times with different values
///
/// A plan names a model, the values to vary with their ranges, and the number of runs to draw. Without a number, every
/// combination is played. Each run gives a row: its values, its status, its level, its strongest partial, its decay,
/// and the time it took. A run that diverges or is not possible gives a row too, with the reason.
///
/// Sounds and rows are written to a folder, in chunks that appear whole or not at all. Finished chunks are not played
/// again, so the same command continues a sweep that was stopped. A run depends only on the model, the seed and its
/// number: any number of threads, machines or parts gives the same `manifest.parquet`, byte for byte.
#[derive(Args)]
#[command(after_long_help = "A plan:
  model = \"plucked_string\"
  seconds = 0.5
  runs = 200                # without: every combination of values
  seed = 1
  audio = \"flac\"            # or \"wav\", \"none\"

  [set]
  \"left.gain\" = 0.5
  \"right.gain\" = 0.5

  [vary]
  \"pick.z\" = { from = \"20 mN s/m\", to = \"0.1 N s/m\" }
  \"pick.k\" = { from = \"1 kN/m\", to = \"9 kN/m\", log = true }
  \"low.f\" = [\"110 Hz\", \"146.83 Hz\", \"220 Hz\"]

It may also have `rate`, `gesture` (files, as of `ca render`), `gesture_rate`, `energy = true`
for the energy ledger, `measure = false` to leave out pitch and decay, `chunk = 10` for the
number of runs written at once, `folder`, and `steps` of a range.

Examples:
  ca sweep plucked.sweep.toml --dry-run
  ca sweep plucked.sweep.toml
  ca sweep plucked.sweep.toml -o takes --threads 2 --json
  ca sweep plucked.sweep.toml -o parts --shard 1/2
  ca sweep plucked.sweep.toml -o parts --shard 2/2")]
pub struct SweepArgs {
    /// The plan, `*.sweep.toml`
    #[arg(value_name = "PLAN.toml")]
    pub plan: PathBuf,
    /// Folder for sounds and rows (default: the folder in the plan, or one beside the plan with its name)
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Plays only part K of N; the parts may run on several machines, in the same folder
    #[arg(long, value_name = "K/N", value_parser = part)]
    pub shard: Option<(u64, u64)>,
    /// Number of threads (default: the number of cores)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Shows what would be played, and plays only the first run
    #[arg(long)]
    pub dry_run: bool,
    /// Prints the summary as JSON
    #[arg(long)]
    pub json: bool,
}

fn part(text: &str) -> Result<(u64, u64), String> {
    let (k, n) = text.split_once('/').ok_or("expected K/N, e.g. `3/64`")?;
    let (k, n) = (k.trim().parse::<u64>(), n.trim().parse::<u64>());
    match (k, n) {
        (Ok(k), Ok(n)) if (1..=n).contains(&k) => Ok((k, n)),
        _ => Err("K must be from 1 to N: of two parts, the first is `1/2` and the other `2/2`".into()),
    }
}

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
            "  {}; {} ms per run and thread",
            list.join(", "),
            short(1e3 * wall * threads as f64 / runs as f64)
        )?;
    }
    let what = if whole { "all runs are done: `manifest.parquet` is written" } else { "other parts are not done yet" };
    writeln!(out, "  {what}")?;
    Ok(Ended::Well)
}

/// Plays `chunks` and counts the runs by status.
fn played(plan: &SweepPlan, folder: &Folder, chunks: &[u64], threads: usize) -> Result<BTreeMap<String, u64>, Failure> {
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
                // other threads would fail in the same way, so one failure ends them all
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

/// Formats the message after Ctrl-C: the runs kept, and how to continue.
fn left(plan: &SweepPlan, folder: &Folder, path: &Path) -> String {
    let there: u64 = (0..folder.chunks()).filter(|c| folder.has(*c)).map(|c| folder.span(c).1 - folder.span(c).0).sum();
    let all = plan.sweep.runs();
    let kept = format!("{there} of {all} runs are kept in `{}`", path.display());
    format!("interrupted: {kept}; run the same command again to continue")
}

/// Shows the plan, plays the first run, and estimates the total time.
fn dry(plan: &SweepPlan) -> Outcome {
    let sweep = &plan.sweep;
    let (row, _) = sweep.run(0, &mut || true)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}  {} runs in {} chunks", plan.folder.display(), sweep.runs(), sweep.runs().div_ceil(plan.chunk))?;
    for (axis, value) in sweep.spec().axes.iter().zip(&row.values) {
        writeln!(out, "  {} = {} in the first run", axis.name, axis.shown(value))?;
    }
    let time = |runs: f64| term::time(row.run_time * runs);
    writeln!(
        out,
        "  the first run is {} and took {}; all runs would take {} with one thread",
        row.status,
        time(1.0),
        time(sweep.runs() as f64)
    )?;
    if !row.message.is_empty() {
        writeln!(out, "  {}", row.message)?;
    }
    Ok(Ended::Well)
}
