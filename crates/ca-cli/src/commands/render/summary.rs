//! Summary of a render: text or JSON on stdout, warnings on stderr.

use super::Probe;
use super::RenderArgs;
use super::play::Audit;
use crate::commands::border;
use crate::load::ticked;
use crate::outcome::Failure;
use crate::term;
use ca_core::{Certificate, Scene, Unit};
use ca_io::level_and_fade::Ended;
use ca_io::low_frequency::EDGE;
use ca_io::sound::Written;
use ca_lab::facts::border::{exchanged, scale_of};
use ca_lab::facts::certificate::stability;
use ca_lab::facts::energy::{compensated, grows, joule, makers};
use ca_lab::facts::inputs;
use ca_lab::facts::level::{FAR, SILENT, decibel, fitting, level, too_loud};
use ca_lab::play::{Divergence, gain, made, relative, unbalanced};
use ca_model::quantity::{short, show, six};
use serde_json::{Value as Json, json};
use std::time::Duration;

/// Limit on the modules named in a line.
const NAMED: usize = 3;

/// Peak above which a sound beyond full scale is a warning, 20 dB over full scale.
const LOUD: f64 = 10.0;

/// Data of the summary.
pub(crate) struct Summary<'a> {
    pub args: &'a RenderArgs,
    pub scene: &'a Scene,
    /// The same scene with the energy ledger, which names its links.
    pub audited: &'a Scene,
    pub written: &'a Written,
    /// Names and gains of the outputs. Empty if a gain is not a plain number.
    pub gains: Vec<(&'a str, f64)>,
    /// Sample format in words.
    pub format: &'static str,
    pub ended: &'a Ended,
    /// Channels with more than half of their content too slow to be heard, with that share.
    pub slow: Vec<(usize, f64)>,
    /// Module with the largest displacement from rest at the end.
    pub furthest: String,
    pub wall: Duration,
    pub energy: Option<&'a Audit>,
    pub divergence: Option<&'a Divergence>,
    pub refused: u64,
    /// Ticks in which contacts were not solved to rounding.
    pub unsolved: u64,
    pub warnings: usize,
    pub probes: &'a [Probe],
}

/// Quotes a word for a shell if necessary.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "._-=/+".contains(c);
    if word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

impl Summary<'_> {
    /// Returns true if the sound is not as intended.
    pub fn degraded(&self) -> bool {
        let energy = self.unbalanced().is_some() || self.made().is_some();
        self.divergence.is_some() || !self.written.is_faithful() || self.refused > 0 || energy
    }

    /// Energy made by the scheme, if it exceeds the energy received \[J\].
    fn made(&self) -> Option<f64> {
        made(&self.energy.filter(|_| self.divergence.is_none())?.ledger.balance())
    }

    /// Residual of the ledger, if the ledger does not balance \[J\].
    fn unbalanced(&self) -> Option<f64> {
        unbalanced(&self.energy.filter(|_| self.divergence.is_none())?.ledger.balance())
    }

    fn loudest(&self) -> f64 {
        self.written.level.peak.iter().copied().fold(0.0, f64::max)
    }

    /// Suggests the gain at which the loudest sample fits, as a factor, and as values for few outputs.
    fn fitting(&self) -> String {
        let peak = self.loudest();
        let value =
            |(name, g): &(&str, f64)| format!("`{name}`: `gain = {}`", short(gain(peak / g.abs()).copysign(*g)));
        let values: Vec<String> = self.gains.iter().filter(|g| g.1 != 0.0).map(value).collect();
        let values =
            if (1..=NAMED).contains(&values.len()) { format!(" ({})", values.join(", ")) } else { String::new() };
        format!("{}{values}", fitting(peak))
    }

    /// Prints the warnings to stderr.
    pub fn warn(&self) {
        if let Some(b) = self.divergence {
            term::warning(&b.to_string());
        } else if self.written.level.non_finite > 0 {
            term::warning(&format!(
                "{} samples were not finite and were replaced by silence",
                self.written.level.non_finite
            ));
        }
        if self.written.level.clipped > 0 {
            // after a divergence, the peak does not indicate loudness
            let help = if self.divergence.is_some() {
                String::new()
            } else if self.warnings > 0 && self.loudest() > FAR {
                format!("; the gain is not the cause, see `{}`", self.check())
            } else {
                self.fitting()
            };
            term::warning(&format!("{}{help}", too_loud(self.written.level.clipped)));
        }
        if self.written.level.beyond > 0 && !self.args.quiet {
            let n = self.written.level.beyond;
            let what = if n == 1 { "1 sample is".into() } else { format!("{n} samples are") };
            let kept = "kept in 32-bit floats; use `--normalize` or `--ceiling` to stay within it";
            let text = format!("{what} beyond full scale, {kept}{}", self.fitting());
            if self.loudest() > LOUD { term::warning(&text) } else { term::note(&text) }
        }
        if self.divergence.is_none() && !self.args.quiet {
            for (channel, share) in &self.slow {
                let name = self.scene.names.channel_names.get(*channel).map_or("", String::as_str);
                let percent = (100.0 * share).round();
                let what = format!("{percent} % of the power of `{name}` is below {EDGE} Hz, which is inaudible");
                let help = match self.furthest.as_str() {
                    "" => "give the output a higher `dc`".into(),
                    body => format!("`{body}` is furthest from rest: attach it, or give the output a higher `dc`"),
                };
                term::warning(&format!("{what}; {help}"));
            }
        }
        if self.loudest() < SILENT && !self.args.quiet {
            let ports: Vec<&str> = self.scene.inputs.iter().map(|i| i.name.as_str()).collect();
            let help = if self.loudest() > 0.0 {
                "all samples are more than 200 dB below full scale: give the outputs more `gain`".into()
            } else if ports.is_empty() {
                "`x` is where a mass rests: displace it with `dx0`, or give it a speed `v`".into()
            } else {
                let midi = inputs::notes(self.scene.inputs.iter());
                let midi = midi.map_or(String::new(), |n| format!("; a MIDI file plays it with the {n}"));
                format!("play it at {} with `--gesture`{midi}", ticked(ports.into_iter()))
            };
            let plays = !self.args.playing.gesture.is_empty() || !self.scene.about.gestures.is_empty();
            let why = if plays { ", because the motion of its gesture does not reach an output" } else { "" };
            term::note(&format!("the sound is silent{why}; {help}"));
        }
        if let Some(residual) = self.unbalanced() {
            let what = format!("the energy ledger does not balance: {} are not accounted for", joule(residual));
            let help = "parameters or positions are too large for 64-bit numbers, or this is a bug of the program";
            term::warning(&format!("{what}; {help}, see `{}`", self.check()));
        }
        if let (Some(made), Some(audit)) = (self.made(), self.energy) {
            let links: Vec<String> =
                makers(self.audited, &audit.ledger, NAMED).into_iter().map(|(name, _)| name).collect();
            let links = ticked(links.iter().map(String::as_str));
            let by = if links.is_empty() { "the rate boundary of a group" } else { &links };
            let received = joule(audit.ledger.balance().received);
            let what = format!("{by} created {} of energy, more than the {received} that were received", joule(made));
            let help = "the sound contains this error of the scheme; lower the stiffness, or give a contact \
                        `method = \"stable\"`";
            term::warning(&format!("{what}: {help}, see `{}`", self.check()));
        }
        if self.refused > 0 {
            term::warning(&format!(
                "{} input values were not finite; the last valid value was used instead",
                self.refused
            ));
        }
    }

    /// Returns the command that shows the findings of this render.
    fn check(&self) -> String {
        let source = &self.args.source;
        let set = source.changes().map(|(name, value)| format!("--set {}", quoted(&format!("{name}={value}"))));
        let rate = source.rate.map(|r| format!("--rate {r}"));
        let words = [String::from("ca check"), quoted(&source.model)].into_iter().chain(set).chain(rate);
        words.collect::<Vec<_>>().join(" ")
    }

    fn real_time_factor(&self) -> f64 {
        self.wall.as_secs_f64() / self.written.duration()
    }

    /// Prints the summary as text.
    pub fn text(&self, mut out: &mut dyn std::io::Write) -> Result<(), Failure> {
        let w = self.written;
        let channels =
            if w.level.peak.len() == 1 { "1 channel".into() } else { format!("{} channels", w.level.peak.len()) };
        let (seconds, khz) = (w.duration(), show(six(self.scene.rate), Unit::HERTZ));
        writeln!(out, "{}  {seconds:.3} s, {channels}, {khz}, {}", w.path.display(), self.format)?;
        let rtf = self.real_time_factor();
        let how = if self.args.energy { " with the energy ledger" } else { "" };
        writeln!(out, "  speed      {} times real time{how} (real-time factor {})", short(1.0 / rtf), short(rtf))?;
        if self.ended.gain != 1.0 {
            writeln!(out, "  gain       all samples times {}", short(self.ended.gain))?;
        }
        if self.ended.faded {
            writeln!(out, "  ending     still sounding: the last 20 ms are faded out; `--no-fade` keeps them")?;
        }
        let name = |i: usize| self.scene.names.channel_names.get(i).map_or("?", String::as_str);
        let peaks: Vec<String> = (0..w.level.peak.len())
            .map(|i| format!("{} {}", name(i), level(w.level.peak[i], self.divergence.is_some())))
            .collect();
        writeln!(out, "  peak       {}", peaks.join(", "))?;
        border::text(&mut out, self.scene)?;
        if let Some(a) = self.energy {
            self.energy(&mut out, a)?;
        }
        writeln!(out, "  stability  {}", stability(&self.scene.certificate))?;
        if self.unsolved > 0 {
            writeln!(out, "  contacts   not solved to rounding in {} ticks", self.unsolved)?;
        }
        for p in self.probes {
            writeln!(out, "  probe      {} → {}", p.name, p.file.display())?;
        }
        if self.warnings > 0 {
            let s = if self.warnings == 1 { "" } else { "s" };
            writeln!(out, "  findings   {} warning{s}, see `{}`", self.warnings, self.check())?;
        }
        Ok(())
    }

    fn energy(&self, out: &mut impl std::io::Write, a: &Audit) -> Result<(), Failure> {
        let b = a.ledger.balance();
        let time = a.ticks as f64 * self.scene.rates.sample_dt;
        if let Some(divergence) = self.divergence {
            // the energy at the last tick in range only measures the divergence
            let grows = grows(self.scene, &a.ledger);
            let found = divergence.time;
            // a shorter audit ended before the divergence and does not know its time
            if a.diverged {
                writeln!(
                    out,
                    "  energy     out of range at {time:.4} s, noticed at {found:.4} s{grows}; silence from there"
                )?;
            } else {
                writeln!(
                    out,
                    "  energy     out of range after {time:.4} s, noticed at {found:.4} s; silence from there; `--energy` shows when"
                )?;
            }
            if a.complete {
                writeln!(out, "    at load  {}", joule(b.h0))?;
                for (name, made) in &makers(self.audited, &a.ledger, 5) {
                    writeln!(out, "      {} made by `{name}` until then", joule(*made))?;
                }
            }
            return Ok(());
        }
        let span = if a.complete {
            String::new()
        } else {
            format!(" (first {} s)", short(time).trim_end_matches('0').trim_end_matches('.'))
        };
        let rel = relative(&b);
        let balance = match rel {
            0.0 => "accounted for exactly".into(),
            _ if !rel.is_finite() => "not accounted for: a sum of it is beyond the range of numbers".into(),
            _ => format!("accounted for to {rel:.1e} of the peak, {}", joule(b.peak)),
        };
        writeln!(out, "  energy     {balance}{span}")?;
        if !a.complete {
            return Ok(());
        }
        writeln!(out, "    at load  {}", joule(b.h0))?;
        writeln!(out, "    received {} from ports, {} by changes", joule(b.work), joule(b.changed))?;
        writeln!(out, "    lost     {}", joule(b.lost))?;
        writeln!(out, "    error    {} of the scheme", joule(b.scheme_error))?;
        for (name, error) in &makers(self.audited, &a.ledger, 5) {
            writeln!(out, "      {} of it by `{name}`", joule(*error))?;
        }
        if b.strayed > 0.0 {
            let share = if b.peak > 0.0 { format!(", {:.1e} of the peak", b.strayed / b.peak) } else { String::new() };
            writeln!(
                out,
                "    off      {} at most, by contacts in space off their potential{share}",
                joule(b.strayed)
            )?;
        }
        if compensated(self.audited) {
            writeln!(
                out,
                "      {} of it by the compensated border of groups at the gesture rate",
                joule(a.ledger.groups.border)
            )?;
        }
        writeln!(out, "    stored   {}", joule(b.h))?;
        for (name, received, given) in exchanged(self.scene, &a.ledger) {
            let (leak, received, given) = (joule(received - given), joule(received), joule(given));
            writeln!(out, "    border   {received} through `{name}`, {given} given by its hand: {leak} by the delay")?;
            if let Some(scale) = self.scene.hand.equivalence.keys.iter().find(|k| k.key == name) {
                writeln!(out, "             `{name}` is {}", scale_of(scale))?;
            }
        }
        Ok(())
    }

    /// Prints the summary as JSON.
    pub fn json(&self, out: &mut dyn std::io::Write) -> Result<(), Failure> {
        let w = self.written;
        let channels: Vec<Json> = (0..w.level.peak.len())
            .map(|i| {
                let dbfs = (w.level.peak[i] > 0.0).then(|| decibel(w.level.peak[i]));
                json!({"name": self.scene.names.channel_names.get(i), "peak": w.level.peak[i], "peak_dbfs": dbfs})
            })
            .collect();
        let energy = self.energy.map(|a| {
            let b = a.ledger.balance();
            let makers: Vec<Json> =
                makers(self.audited, &a.ledger, 5).iter().map(|(n, v)| json!({"link": n, "made": v})).collect();
            let hands: Vec<Json> = exchanged(self.scene, &a.ledger)
                .iter()
                .map(|(name, r, g)| json!({"name": name, "received": r, "given": g, "leak": r - g}))
                .collect();
            json!({
                "seconds": a.ticks as f64 * self.scene.rates.sample_dt, "whole": a.complete, "residual": b.residual,
                "relative_residual": relative(&b), "off_potential": b.strayed, "peak": b.peak, "at_load": b.h0, "received": b.work,
                "changed": b.changed, "lost": b.lost, "made": b.scheme_error, "held": b.h, "makers": makers,
                "hands": hands, "made_at_border": compensated(self.audited).then_some(a.ledger.groups.border),
            })
        });
        let divergence =
            self.divergence.map(|b| json!({"seconds": b.time, "module": b.module, "why": b.why, "fix": b.fix}));
        let clipped = (w.level.clipped > 0).then(|| {
            // after a divergence, the peak does not indicate loudness
            let gain = self.divergence.is_none().then(|| gain(self.loudest()));
            json!({"samples": w.level.clipped, "gain": gain})
        });
        let probes: Vec<Json> = self.probes.iter().map(|p| json!({"name": p.name, "file": p.file})).collect();
        let all = json!({
            "file": w.path, "seconds": w.duration(), "frames": w.frames, "rate": w.rate, "format": self.format,
            "channels": channels, "latency": border::json(self.scene), "real_time_factor": self.real_time_factor(), "energy": energy,
            "stability": stability_json(&self.scene.certificate), "warnings": self.warnings, "probes": probes,
            "clipped": clipped, "beyond_full_scale": w.level.beyond, "gain": self.ended.gain, "faded": self.ended.faded,
            "slow": self.slow.iter().map(|(c, share)| json!({"channel": c, "share": share})).collect::<Vec<_>>(),
            "without_value": w.level.non_finite, "refused_inputs": self.refused, "unsolved_ticks": self.unsolved, "blown_up": divergence,
            "degraded": self.degraded(),
        });
        writeln!(out, "{all:#}")?;
        Ok(())
    }
}

pub(crate) fn stability_json(c: &Certificate) -> Json {
    json!({
        "level": c.level.to_string(), "bound": c.bound, "lower": c.lower, "limit": 4.0, "margin": c.margin(),
        "exact": c.exact, "largest": c.largest.map(|l| [l.0, l.1]), "ripple": c.ripple,
        "worst": c.worst, "contact": c.rules.contact, "stiffest": c.rules.stiffest,
        "depth": c.rules.depth.as_ref().map(|(name, m)| json!({"contact": name, "m": m})), "friction": c.rules.friction,
        "closed": c.rules.closed, "decides": c.rules.decides, "open": c.rules.open, "not_judged": c.not_judged,
    })
}
