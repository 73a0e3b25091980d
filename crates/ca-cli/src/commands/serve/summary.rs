//! Summary at the end of a performance.

use ca_core::Unit;
use ca_haptic::stats::Percentiles;
use ca_live::Report;
use ca_model::quantity::short;
use ca_model::quantity::{show, six};
use serde_json::{Value, json};
use std::io::{self, Write as _};

pub(super) fn text(report: &Report) -> io::Result<()> {
    let Report { name, rate, summary: s, traffic, sound, take } = report;
    let mut out = io::stdout().lock();
    writeln!(out, "{name}: {} s in {} gesture frames of {:.1} us", short(s.seconds), s.frames, s.period_us)?;
    for (thread, granted) in &s.granted {
        writeln!(out, "  {thread:<15}{granted}")?;
    }
    writeln!(out, "  {:<15}{}", "a frame takes", times(&s.frame_us))?;
    writeln!(out, "  {:<15}{}; {} periods left out", "begins late", times(&s.late_us), s.missed)?;
    for d in &s.devices {
        let loops = if d.loop_us.n == 0 { "never closed".into() } else { times(&d.loop_us) };
        writeln!(out, "  {:<15}{} frames, {} dropped; loop {loops}", d.device, d.frames, d.dropped)?;
    }
    for d in s.devices.iter().filter(|d| !d.forces_on || d.waits.is_some()) {
        let before = if d.forces_on { "off at the end, on before" } else { "off to the end" };
        let why = d.waits.as_ref().map_or_else(String::new, |w| format!("; armed, but {w}"));
        writeln!(out, "  {:<15}{}: {before}{why}", "forces", d.device)?;
    }
    for (d, (key, felt)) in s.devices.iter().flat_map(|d| d.softened.iter().map(move |s| (d, s))) {
        let felt = show(six(*felt), Unit::STIFFNESS);
        writeln!(out, "  {:<15}`{key}` to {felt} in the hand, which {} can hold", "softened", d.device)?;
    }
    if !s.devices.is_empty() {
        writeln!(
            out,
            "  {:<15}{} frames without a new device frame, {} forces not read",
            "stale", s.stale, s.lost_forces
        )?;
    }
    let on_the_way: Vec<String> =
        traffic.iter().flatten().filter(|t| t.1 > 0).map(|(k, n)| format!("{n} {k}")).collect();
    if !on_the_way.is_empty() {
        writeln!(out, "  {:<15}{}", "frames", on_the_way.join(", "))?;
    }
    let lost =
        [(s.lost_records, "records"), (s.lost_sound, "samples"), (s.lost_views, "pictures"), (s.lost_timings, "times")];
    let lost: Vec<String> = lost.iter().filter(|l| l.0 > 0).map(|(n, what)| format!("{n} {what}")).collect();
    let nothing = if s.broken.is_empty() { "nothing" } else { "see `not written` below" };
    writeln!(out, "  {:<15}{}", "lost", if lost.is_empty() { nothing.into() } else { lost.join(", ") })?;
    if s.faults.is_empty() {
        writeln!(out, "  {:<15}none", "faults")?;
    }
    for f in &s.faults {
        writeln!(out, "  {:<15}{} {} at {:.3} s", "fault", f.device, f.cause.name(), f.tick as f64 / *rate)?;
    }
    for what in &s.broken {
        writeln!(out, "  {:<15}{what}", "not written")?;
    }
    if s.clipped > 0 {
        writeln!(out, "  {:<15}{} samples at full scale", "clipped", s.clipped)?;
    }
    for a in s.audio_before.iter().chain(&s.audio) {
        let (rate, buffer, ms, ppm) = (a.playback.rate, a.buffer, short(a.latency_ms), a.ppm);
        let who = format!("{} ({})", a.playback.device, a.playback.host);
        writeln!(out, "  {:<15}{who}, {rate} Hz {ppm:+.1} ppm, {buffer} frames, heard after {ms} ms", "played by")?;
        let lost = [
            (a.underruns, "underruns"),
            (a.xruns, "xruns of the device"),
            (a.stops, "times the device stopped"),
            (a.silent, "samples of silence"),
            (a.skipped, "samples too old"),
            (a.unheard, "samples that the device did not take"),
        ];
        let lost: Vec<String> = lost.iter().filter(|l| l.0 > 0).map(|(n, what)| format!("{n} {what}")).collect();
        writeln!(out, "  {:<15}{}", "not played", if lost.is_empty() { "nothing".into() } else { lost.join(", ") })?;
    }
    if let Some((path, w)) = sound {
        writeln!(out, "  {:<15}{}, {} s", "sound", path.display(), short(w.duration()))?;
    }
    if let Some((path, t)) = take {
        let lost = if t.lost > 0 { format!(", {} lost", t.lost) } else { String::new() };
        writeln!(out, "  {:<15}{}, {} messages{lost}; `ca replay` plays it again", "take", path.display(), t.messages)?;
    }
    Ok(())
}

fn times(t: &Percentiles) -> String {
    format!("p50 {}  p99 {}  p99.9 {}  max {} us", short(t.p50), short(t.p99), short(t.p999), short(t.max))
}

pub(super) fn value(report: &Report) -> Value {
    let mut v = serde_json::to_value(&report.summary).unwrap_or_default();
    v["model"] = json!(report.name);
    v["traffic"] = report.traffic.map(|t| t.into_iter().collect::<Value>()).into();
    v["faithful"] = json!(report.summary.is_faithful());
    v["sound"] = json!(report.sound.as_ref().map(|(p, _)| p));
    v["take"] = json!(report.take.as_ref().map(|(p, t)| json!({"file": p, "messages": t.messages, "lost": t.lost})));
    v
}
