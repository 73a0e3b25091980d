//! `ca log`: shows the contents of a take, recovers a truncated take, and exports parts of it.
//!
//! Existing files are overwritten only with `--force`, and recovery writes a new file. Exit code 3 means that the
//! command succeeded, but the take lacks a part of the performance.

use super::{LogArgs, LogCommand};
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, term};
use ca_haptic::take::{End, Summary, Take, export, recover};
use ca_model::printable::printable;
use serde_json::json;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Runs the command.
pub fn run(args: &LogArgs) -> Outcome {
    match &args.what {
        LogCommand::Info { file, json } => {
            let take = Take::open(file)?;
            let summary = take.summary()?;
            if *json {
                info_json(&take, &summary)?;
            } else {
                info(&take, &summary)?;
            }
            if summary.end != End::Whole {
                let fix = format!("`ca log recover {}` copies the intact part", file.display());
                term::warning(&format!("{}; {fix}", summary.end));
            }
            let damaged = matches!(summary.end, End::Damaged(..));
            Ok(if damaged || summary.lost[0] + summary.lost[1] > 0 { Ended::Degraded } else { Ended::Well })
        }
        LogCommand::Recover { file, output, force } => recovered(file, output.as_ref(), *force),
        LogCommand::Export { file, what, output, force } => exported(file, what, output, *force),
    }
}

/// Refuses to overwrite the take, or without `force` any existing file.
fn free(path: &Path, from: &Path, force: bool) -> Result<(), Failure> {
    outputs::check_distinct(&[("-o", path)], &[("the take", from)])?;
    if path.is_file() && !force {
        return Err(Failure::Failed(format!("`{}` exists; use `--force` to overwrite it", path.display())));
    }
    Ok(())
}

fn recovered(file: &Path, output: Option<&PathBuf>, force: bool) -> Outcome {
    let name = file.file_stem().unwrap_or_default().to_string_lossy();
    let to = output.cloned().unwrap_or_else(|| file.with_file_name(format!("{name}.recovered.mcap")));
    free(&to, file, force)?;
    let r = recover(file, &to)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{}: {} messages, {:.3} s, {} attachments", to.display(), r.messages, r.seconds, r.attachments)?;
    drop(out);
    match r.cut {
        None => {
            term::note("the take was complete; the new file is a copy of it");
            Ok(Ended::Well)
        }
        Some((why, bytes)) => {
            let text = if r.damaged {
                format!(
                    "the take is damaged: {why}, {bytes} bytes from there on were not used; \
                     the performance after that is lost"
                )
            } else {
                let less = "the last quarter of a second that was played had not been written yet";
                format!("the take was cut off: {why}, {bytes} bytes at its end were not usable; {less}")
            };
            term::warning(&text);
            Ok(Ended::Degraded)
        }
    }
}

fn exported(file: &Path, what: &str, to: &Path, force: bool) -> Outcome {
    free(to, file, force)?;
    let take = Take::open(file)?;
    let mut out = std::io::stdout().lock();
    match what {
        "sound" => {
            let w = export::sound(&take, to)?;
            writeln!(out, "{}: {:.3} s, {} channels", to.display(), w.duration(), w.level.peak.len())?;
        }
        "model" => {
            let n = export::attachment(&take, &format!("model/{}", take.header.file), to)?;
            writeln!(out, "{}: {n} bytes, as its author wrote it", to.display())?;
            if !take.header.changes.is_empty() {
                let set = take.header.changes.iter().map(|(n, v)| format!("--set {n}='{v}'"));
                drop(out);
                term::note(&format!("it was played with {}", set.collect::<Vec<_>>().join(" ")));
            }
        }
        topic if topic.starts_with('/') => {
            let n = export::messages(&take, topic, to)?;
            writeln!(out, "{}: {n} messages of {topic}", to.display())?;
        }
        name => {
            let n = export::attachment(&take, name, to)?;
            writeln!(out, "{}: {n} bytes", to.display())?;
        }
    }
    Ok(Ended::Well)
}

fn bytes(n: u64) -> String {
    match n {
        0..10_000 => format!("{n} B"),
        10_000..10_000_000 => format!("{} kB", n / 1000),
        _ => format!("{} MB", n / 1_000_000),
    }
}

fn info(take: &Take, s: &Summary) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let h = &take.header;
    let size = std::fs::metadata(&take.path).map_or(0, |m| m.len());
    writeln!(out, "{}: {:.3} s of `{}`, {}", take.path.display(), s.seconds, printable(&h.title), bytes(size))?;
    let get = |key: &str| h.host.get(key).map_or("?", String::as_str);
    writeln!(out, "  written by ca {} on {} {}", get("ca"), get("os"), get("arch"))?;
    writeln!(out, "  rates      sound {} Hz, gesture {} Hz", h.rate, h.rate / f64::from(h.ratio))?;
    for d in &h.setups {
        writeln!(out, "  device     `{}`, {} DOF, {}", d.device, d.profile.dof, d.profile.title)?;
    }
    for (name, value) in &h.changes {
        writeln!(out, "  set        {name} = {value}")?;
    }
    let wide = s.topics.keys().map(String::len).max().unwrap_or(0).max(5);
    writeln!(out, "  {:wide$}  {:>9}  {:>10}  {:>9}  content", "topic", "messages", "per second", "bytes")?;
    for (name, t) in &s.topics {
        let rate = t.rate().map_or_else(|| "-".into(), |r| format!("{r:.1}"));
        let of = bytes(t.bytes);
        writeln!(out, "  {name:wide$}  {:>9}  {rate:>10}  {of:>9}  {} ({})", t.messages, t.schema, t.encoding)?;
    }
    for (name, n) in &s.attachments {
        writeln!(out, "  attached   {name}, {}", bytes(*n))?;
    }
    for f in &s.faults {
        writeln!(out, "  fault      {} at {:.4} s, `{}`", f.cause.name(), f.time, f.device)?;
    }
    let [records, samples, views] = s.lost;
    if records + samples + views > 0 {
        writeln!(out, "  lost       {records} records, {samples} sound samples, {views} views")?;
    }
    Ok(())
}

fn info_json(take: &Take, s: &Summary) -> Result<(), Failure> {
    let h = &take.header;
    let topics: serde_json::Map<String, serde_json::Value> = s
        .topics
        .iter()
        .map(|(name, t)| {
            let all = json!({
                "messages": t.messages, "bytes": t.bytes, "schema": t.schema, "encoding": t.encoding, "rate": t.rate(),
            });
            (name.clone(), all)
        })
        .collect();
    let faults: Vec<_> =
        s.faults.iter().map(|f| json!({"device": f.device, "time": f.time, "cause": f.cause.name()})).collect();
    let devices: Vec<_> =
        h.setups.iter().map(|d| json!({"name": d.device, "profile": d.profile.name, "dof": d.profile.dof})).collect();
    let cut = s.end.early().map(|(why, bytes)| json!({"why": why, "bytes": bytes}));
    let all = json!({
        "file": take.path.display().to_string(), "title": h.title, "model": h.file, "set": h.changes,
        "seconds": s.seconds, "sound_rate": h.rate, "gesture_rate": h.rate / f64::from(h.ratio), "host": h.host,
        "devices": devices, "topics": topics, "faults": faults, "cut": cut,
        "attachments": s.attachments.iter().map(|a| &a.0).collect::<Vec<_>>(),
        "lost": {"records": s.lost[0], "samples": s.lost[1], "views": s.lost[2]},
    });
    writeln!(std::io::stdout().lock(), "{all:#}")?;
    Ok(())
}
