//! Error against run time of a model, over methods and rates.
//!
//! The values that outputs read are compared, before gains and filters: filters are the same for all candidates, and
//! their dependence on the rate would count as an error of the scheme.
#![forbid(unsafe_code)]

pub mod bench;
mod choice;
mod effort;
mod methods;
mod play;
mod reference;
mod reported;
pub mod schedule;
mod score;
mod single;
#[cfg(test)]
mod tests;
pub mod timing;

pub use single::bound as single;

use ca_compile::Options;
use ca_core::{Balance, Level, Scene};
use ca_lab::Failure;
use ca_lab::load::{self, Loaded};
use ca_model::Model;
use ca_model::Value;
use ca_report::{Axis, Block, Plot, Point, Section, Table};
pub use choice::{Choice, choose};
pub use methods::changes;
use methods::{AS_WRITTEN, Candidate, candidates};
use reference::Reference;
pub use reference::{Origin, Second};
pub use reported::Reported;
use score::Score;
use timing::Clock;

/// Rounds of timing, and least time per candidate and round \[ns\]. The fastest counts: the others were disturbed.
const ROUNDS: usize = 4;
const TURN: f64 = 1e7;

/// Run time that is measured once \[ns\]; twice in a browser, which optimises code while it runs.
const LONG: f64 = 1e8;

/// Highest rate at which a model is compiled \[Hz\].
const HIGHEST: f64 = 1e7;

/// Maximum number of samples per candidate, over all probes; it limits the duration.
const MOST: f64 = 5e7;

/// Title of the section.
pub const TITLE: &str = "Error against run time";

/// Approximate run time of the reference, and of all rows, of a model for which they are chosen \[s\].
pub const BUDGET: f64 = 10.0;

/// Measured candidate.
pub struct MethodRow {
    /// Name of the method.
    pub method: &'static str,
    /// Multiple of the rate.
    pub times: u32,
    /// Distance from the reference.
    pub score: Score,
    /// Time per sample at the rate of the model \[ns\].
    pub ns: f64,
    /// Level of its certificate.
    pub level: Level,
    /// Energy ledger at the end, if there is one.
    balance: Option<Balance>,
    /// True if no other candidate beats it in both error and time.
    pub front: bool,
}

impl MethodRow {
    /// Display name.
    pub fn name(&self) -> String {
        if self.times == 1 { self.method.into() } else { format!("{} x{}", self.method, self.times) }
    }

    /// Energy made by the scheme, relative to the peak of the energy.
    pub fn energy_error(&self) -> Option<f64> {
        self.balance.filter(|b| b.peak > 0.0).map(|b| (b.scheme_error.abs() + b.residual.abs()) / b.peak)
    }
}

/// Options of a measurement.
pub struct AccuracyOptions<'a> {
    /// Sound rate \[Hz\]; as the model if `None`.
    pub rate: Option<f64>,
    /// Probes to compare.
    pub probes: &'a [String],
    /// Duration \[s\]; as the model, up to one second, if `None`.
    pub seconds: Option<f64>,
    /// Multiples of the rate; if `None`, as many of 1, 2, 4 and 8 as take about [`BUDGET`].
    pub times: Option<&'a [u32]>,
    /// Multiple of the rate for the reference; if `None`, the largest from 8 to 64 that takes about [`BUDGET`].
    pub reference: Option<u32>,
    /// Advice in the message for a model in which nothing moves.
    pub remedy: &'static str,
    /// Clock for run times.
    pub clock: Clock,
    /// Called regularly with the number of finished steps and of all steps; false stops the measurement.
    pub progress: &'a mut dyn FnMut(u64, u64) -> bool,
}

/// Result of a measurement.
pub struct Measured {
    /// One row per candidate.
    pub rows: Vec<MethodRow>,
    /// Reference of the comparison.
    pub reference: Reference,
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Samples played.
    pub frames: usize,
    /// Methods that the model cannot use, with the reason.
    pub refused: Vec<(&'static str, String)>,
    /// Warnings that the compiler gives only with a method.
    pub warned: Vec<(&'static str, String)>,
}

/// Measures a model.
///
/// # Errors
/// If the model does not compile, if nothing moves, or if `progress` returns false.
pub fn measured(loaded: &Loaded, ask: &mut AccuracyOptions) -> Result<Measured, Failure> {
    let probes = ask.probes.to_vec();
    let scene = loaded.compile(&Options { rate: ask.rate, probes: probes.clone(), ..Options::default() })?;
    let rate = scene.rate;
    let (seconds, times, multiple) = effort::chosen(ask, &scene)?;
    let samples = seconds * rate;
    if !(samples > 0.0 && samples * probes.len() as f64 <= MOST) {
        let most = MOST / (rate * probes.len() as f64);
        return Err(Failure::Usage(format!(
            "a length of {seconds} s is not allowed; play more than 0 s and at most {most:.0} s"
        )));
    }
    let frames = samples.round().max(16.0) as usize;
    let finest = times.iter().copied().max().map_or(multiple, |t| t.max(multiple));
    if f64::from(finest) * rate > HIGHEST {
        let most = (HIGHEST / rate).floor();
        let what = format!("{finest} times {rate} Hz is above the limit of {HIGHEST:e} Hz");
        return Err(Failure::Usage(format!("{what}; use at most {most} times the rate")));
    }
    let candidates = candidates(loaded, &probes, rate, &times);
    let mut steps =
        Steps { done: 0, of: (candidates.all.len() * ROUNDS + 1) as u64, clock: ask.clock, tell: &mut *ask.progress };
    steps.look()?;
    let reference = reference::reference(loaded, &probes, &scene, (frames, multiple), &mut steps)?;
    steps.step()?;
    if reference.columns.iter().flatten().all(|v| *v == 0.0) {
        let what = format!("no motion of {} within {seconds} s", load::ticked(probes.iter().map(String::as_str)));
        return Err(Failure::Failed(format!("{what}; {}", ask.remedy)));
    }
    let mut rows = Vec::with_capacity(candidates.all.len());
    for candidate in &candidates.all {
        rows.push(row(candidate, &reference, frames, rate, &mut steps)?);
        steps.step()?;
    }
    for round in 1..ROUNDS {
        for (candidate, row) in candidates.all.iter().zip(&mut rows) {
            let cold = round == 1 && steps.clock.is_coarse();
            if row.ns * frames as f64 > LONG && !cold {
                steps.step()?;
                continue;
            }
            row.ns = row.ns.min(turn(candidate, frames, &mut steps)?);
            steps.step()?;
        }
    }
    mark(&mut rows);
    Ok(Measured { rows, reference, rate, frames, refused: candidates.refused, warned: candidates.warned })
}

/// Returns the names of the outputs of a model, one for each distinct source. As a probe, the name of an output reads
/// its source along its direction, before gain and filters.
pub fn heard(model: &Model) -> Vec<String> {
    let mut all = Vec::new();
    let mut known: Vec<(&str, [Option<&Value>; 2])> = Vec::new();
    for i in model.items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF")) {
        let value = |key: &str| i.args.iter().find(|e| e.key == key).map(|e| &e.value);
        let what = (i.kind.as_str(), [value("from"), value("along")]);
        if what.1[0].is_some() && !known.contains(&what) {
            known.push(what);
            all.push(i.name.clone());
        }
    }
    all
}

/// Returns the probe index of each column. The axes of one place in space are one probe, whose error is a distance.
fn bodies(scene: &Scene) -> Vec<usize> {
    let place = |name: &str| match name.rsplit_once('.') {
        Some((place, "x" | "y" | "z")) => place.to_owned(),
        _ => name.to_owned(),
    };
    let mut of: Vec<usize> = Vec::with_capacity(scene.names.probe_names.len());
    let mut last = None;
    for (name, asked) in scene.names.probe_names.iter().zip(&scene.names.probe_of) {
        let here = Some((place(name), *asked));
        let next = of.last().map_or(0, |n| n + usize::from(here != last));
        of.push(next);
        last = here;
    }
    of
}

struct Steps<'a> {
    done: u64,
    of: u64,
    clock: Clock,
    tell: &'a mut dyn FnMut(u64, u64) -> bool,
}

impl Steps<'_> {
    fn step(&mut self) -> Result<(), Failure> {
        self.done += 1;
        self.look()
    }

    fn look(&mut self) -> Result<(), Failure> {
        if (self.tell)(self.done, self.of) { Ok(()) } else { Err(Failure::Stopped) }
    }
}

fn row(
    candidate: &Candidate,
    reference: &Reference,
    frames: usize,
    rate: f64,
    steps: &mut Steps,
) -> Result<MethodRow, Failure> {
    let (columns, mut ns) = candidate.play(frames, steps)?;
    if ns * (frames as f64) < steps.clock.least() {
        ns = turn(candidate, frames, steps)?;
    }
    let balance = candidate.audited.as_ref().and_then(|s| play::ledger(s, frames as u64 * u64::from(candidate.times)));
    Ok(MethodRow {
        method: candidate.method,
        times: candidate.times,
        score: score::score(&columns, &reference.columns, &reference.of, rate),
        ns,
        level: candidate.scene.certificate.level,
        balance,
        front: false,
    })
}

/// Returns the fastest time per sample of a candidate in one round \[ns\]. Plays too short for the clock are timed
/// together.
fn turn(candidate: &Candidate, frames: usize, steps: &mut Steps) -> Result<f64, Failure> {
    let (mut best, mut whole) = (f64::INFINITY, 0.0);
    while whole < TURN {
        let (mut ns, mut samples) = (0.0, 0.0);
        while samples == 0.0 || ns < steps.clock.least() {
            ns += candidate.play(frames, steps)?.1 * frames as f64;
            samples += frames as f64;
        }
        (best, whole) = (best.min(ns / samples), whole + ns);
    }
    Ok(best)
}

/// Marks candidates that no other beats in both error and time.
fn mark(rows: &mut [MethodRow]) {
    for i in 0..rows.len() {
        let (e, t) = (rows[i].score.error, rows[i].ns);
        let beaten = rows
            .iter()
            .enumerate()
            .any(|(j, r)| j != i && r.score.error <= e && r.ns <= t && (r.score.error < e || r.ns < t));
        rows[i].front = e.is_finite() && !beaten;
    }
}

/// Formats a number for a table.
fn small(v: f64) -> String {
    if v.is_finite() { format!("{v:.1e}") } else { "-".into() }
}

impl Measured {
    /// Describes the reference in words.
    pub fn origin(&self) -> String {
        let (known, method) = (self.reference.known, self.reference.method);
        let by = if method == AS_WRITTEN { String::new() } else { format!(" by {method}") };
        let alone = |text: String| match self.reference.second {
            Some(Second { method, apart, agrees: true }) => format!("{text}; {method} agrees to {apart:.0e}"),
            Some(Second { method, apart, .. }) => {
                format!("the model{by}, but it is not known: {method} differs from it by {apart:.0e}")
            }
            None => format!("{text}, by one method alone"),
        };
        match self.reference.origin {
            Origin::Modes => format!("the closed form of its modes, accurate to {known:.0e}"),
            Origin::Rate(n, p) => alone(format!(
                "the model{by} at {n} times the rate, converging with order {p:.1}, accurate to {known:.0e}"
            )),
            Origin::Open(n) => alone(format!(
                "the model{by} at {n} times the rate, which does not converge evenly: accurate to {known:.0e}"
            )),
        }
    }

    /// Duration played \[s\].
    pub fn seconds(&self) -> f64 {
        self.frames as f64 / self.rate
    }

    /// Returns a row of the table.
    pub fn cells(&self, r: &MethodRow) -> Vec<String> {
        let under = r.score.error < self.reference.known;
        vec![
            if r.front { format!("{} *", r.name()) } else { r.name() },
            if under { format!("<{}", small(self.reference.known)) } else { small(r.score.error) },
            small(r.score.spectrum),
            r.score.cents.filter(|c| c.is_finite()).map_or("-".into(), |c| format!("{c:+.3}")),
            if r.score.error.is_finite() { format!("{:+.3}", r.score.decay) } else { "-".into() },
            r.energy_error().map_or("-".into(), small),
            format!("{:.0}", r.ns),
            format!("{:.2}", 1e9 / (r.ns * self.rate)),
            r.level.to_string(),
        ]
    }

    /// Returns the row of the model as it is written.
    pub fn as_written(&self) -> Option<&MethodRow> {
        self.rows.iter().find(|r| r.method == AS_WRITTEN && r.times == 1)
    }

    /// Head of the table.
    pub const HEAD: [&'static str; 9] =
        ["method", "error", "spectrum", "cents", "decay dB", "energy", "ns/sample", "x real time", "stability"];

    /// Returns the plot, with a chosen row marked and named `what`, the table and the remarks on methods.
    pub fn section(&self, chosen: Option<(&MethodRow, &str)>) -> Section {
        let points = self.rows.iter().map(|r| Point {
            name: r.name(),
            x: r.ns,
            y: r.score.error.max(self.reference.known),
            front: r.front,
        });
        let (x, y) = (Axis::log("time of a sample", "ns"), Axis::log("error", ""));
        let plot = Plot::scatter(TITLE, x, y, "no method is better in both", "others", &points.collect::<Vec<_>>());
        let plot = match chosen {
            Some((r, what)) => plot.with_chosen(what, [r.ns, r.score.error.max(self.reference.known)]),
            None => plot,
        };
        let table = Table::new(&Self::HEAD, self.rows.iter().map(|r| self.cells(r)).collect());
        let how = format!("{:.3} s at {} Hz, against {}.", self.seconds(), self.rate, self.origin());
        let mut blocks = vec![Block::Text(how), Block::Plot(plot), Block::Table(table)];
        let reported = |list: &[(&'static str, String)]| -> Vec<Vec<String>> {
            list.iter().map(|(m, what)| vec![(*m).to_owned(), what.clone()]).collect()
        };
        for (head, list) in [("why it is not possible", &self.refused), ("warning", &self.warned)] {
            if !list.is_empty() {
                blocks.push(Block::Table(Table::new(&["method", head], reported(list))));
            }
        }
        Section::new(TITLE, blocks)
    }
}
