//! `ca replay`: replays a take and compares the result with the record.
//!
//! A replay always compares. `--verify` only decides whether a difference is a failure (test of a build) or a report
//! (another version or machine).

use super::ReplayArgs;
use crate::outcome::{Ended, Failure, Outcome};
use crate::{outputs, term};
use ca_core::ARITHMETIC;
use ca_haptic::take::{Replay, ReplayVerdict, Take};
use ca_io::format::Format;
use ca_io::sound::WavOut;
use ca_lab::catalog;
use ca_model::printable::printable;
use ca_model::quantity::short;
use ca_take::account::Account;
use serde_json::{Value, json};
use std::io::Write;

/// Runs the command.
pub fn run(args: &ReplayArgs) -> Outcome {
    if let Some(path) = &args.output {
        ca_live::check_wav_path(path)?;
        outputs::check_distinct(&[("-o", path)], &[("the take", &args.file)])?;
    }
    let mut take = Take::open(&args.file)?;
    // the ledger does not change the bits of the sound, as the comparison shows
    take.header.options.energy |= args.energy;
    let mut replay = Replay::new(&take, &catalog())?;
    let channels = replay.engine.scene.counts.channels;
    let wav = args.output.as_ref().map(|p| WavOut::create(p, take.header.rate, channels, Format::F32));
    let mut wav = wav.transpose()?;
    let verdict = replay.run(&take, &mut |_| (), &mut |heard| wav.as_mut().map_or(Ok(()), |w| w.write(heard)))?;
    if let Some(wav) = wav {
        wav.finish()?;
    }
    let account = if args.energy { Account::of(&replay.engine) } else { None };
    if args.json {
        json_of(&take, &verdict, account.as_ref())?;
    } else {
        text(&take, &verdict, account.as_ref())?;
    }
    if verdict.is_identical() {
        return Ok(Ended::Well);
    }
    if args.verify { Err(Failure::Reported) } else { Ok(Ended::Degraded) }
}

fn text(take: &Take, v: &ReplayVerdict, account: Option<&Account>) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let title = if take.header.title.is_empty() { &take.header.file } else { &take.header.title };
    writeln!(out, "{}: {:.3} s of `{}`", take.path.display(), v.seconds, printable(title))?;
    writeln!(
        out,
        "  compared   {} force frames, {} sound samples, {} hashes of the state",
        v.forces, v.samples, v.hashes
    )?;
    let alike = alike(v);
    match (&v.difference, v.hole) {
        (None, None) if !v.is_identical() => {
            writeln!(out, "  nothing was compared: the take has no forces, sound or hashes")?;
        }
        (None, None) => writeln!(out, "  {alike}")?,
        (Some(d), _) => writeln!(out, "  differs    {d}")?,
        (None, Some(t)) => writeln!(out, "  {alike}, up to {t:.3} s: records are missing there")?,
    }
    if v.tolerance > 0.0 {
        let by = take.header.arithmetic;
        writeln!(out, "  arithmetic {by} in the take, {ARITHMETIC} here: rounding differs, so bits are not compared")?;
    }
    if v.versions > 1 {
        let energy = if account.is_some() { "; the energy is since the last one" } else { "" };
        writeln!(out, "  {} versions of the model were played{energy}", v.versions)?;
    }
    if let Some(account) = account {
        account_text(account, &mut out)?;
    }
    drop(out);
    if let Some(why) = &v.cut {
        if v.damaged {
            term::warning(&format!("the file is damaged: {why}; nothing after that was compared"));
        } else {
            term::note(&format!("the file was cut off: {why}"));
        }
    }
    Ok(())
}

/// Describes a matching replay.
fn alike(v: &ReplayVerdict) -> String {
    if v.tolerance > 0.0 {
        format!("agrees     to {:e} of the peak", v.tolerance)
    } else {
        "identical  to the bit".into()
    }
}

fn json_of(take: &Take, v: &ReplayVerdict, account: Option<&Account>) -> Result<(), Failure> {
    let difference = v
        .difference
        .as_ref()
        .map(|d| json!({"tick": d.tick, "time": d.time, "what": d.what, "was": d.was, "is": d.is}));
    let all = json!({
        "file": take.path.display().to_string(), "title": take.header.title, "seconds": v.seconds,
        "identical": v.is_identical(), "tolerance": v.tolerance, "gesture_frames": v.frames, "device_frames": v.taken, "force_frames": v.forces,
        "samples": v.samples, "hashes": v.hashes, "difference": difference, "hole": v.hole, "cut": v.cut,
        "damaged": v.damaged, "versions": v.versions,
        "energy": account.map(account_json),
    });
    writeln!(std::io::stdout().lock(), "{all:#}")?;
    Ok(())
}

/// Prints the account as text, without rows that are zero.
fn account_text(account: &Account, out: &mut impl Write) -> std::io::Result<()> {
    let given = account.sources[0].1;
    let names = account.sources.iter().chain(&account.sinks).map(|r| r.0.chars().count());
    let wide = names.max().unwrap_or(0).max(28);
    for (i, (what, j)) in account.sources.iter().chain(&account.sinks).enumerate() {
        let lead = if i == 0 { "energy" } else { "" };
        // omits rows that consist of rounding errors
        if i == 0 || j.abs() > 1e-12 * account.peak {
            let part = if given > 0.0 && i > 0 { format!(" {:>8.3} %", 100.0 * j / given) } else { String::new() };
            writeln!(out, "  {lead:<10} {what:<wide$} {:>10} mJ{part}", short(1e3 * j))?;
        }
    }
    writeln!(
        out,
        "  {:<10} {:<wide$} {:>10.1e} of its peak",
        "",
        "not explained",
        account.residual().abs() / account.peak
    )
}

fn account_json(account: &Account) -> Value {
    let rows = |list: &[(String, f64)]| list.iter().map(|(n, j)| json!({"what": n, "joules": j})).collect::<Vec<_>>();
    json!({
        "sources": rows(&account.sources), "sinks": rows(&account.sinks), "residual": account.residual(), "peak": account.peak,
    })
}
