//! `ca accuracy`: error against run time, over methods and rates.
//!
//! Decides to compare what the outputs listen to, not what they give: gains, high and low passes are the same for all
//! ways, and those that hang on the rate would be counted as errors of the scheme.

mod play;
mod score;
mod truth;
mod ways;

use crate::args::AccuracyArgs;
use crate::load::{self, Loaded};
use crate::{Ended, Failure, Outcome, page, term};
use ca_core::certificate::Level;
use ca_core::energy::Balance;
use ca_core::model::Value;
use ca_core::{Model, Options};
use ca_report::{Axis, Block, Plot, Point, Report, Section, Table};
use score::Score;
use serde_json::{Value as Json, json};
use std::io::Write as _;
use truth::{Origin, Truth};
use ways::{Way, ways};

/// Each way is timed so often, and the quickest counts: the others were disturbed.
const REPEATS: usize = 3;

/// As long as a model is played if nothing is said \[s\].
const LONGEST: f64 = 1.0;

/// A way, measured.
struct Row {
    method: &'static str,
    times: u32,
    score: Score,
    /// of one sample of the model's own rate
    ns: f64,
    level: Level,
    balance: Option<Balance>,
    /// nothing is both more exact and quicker
    front: bool,
}

impl Row {
    /// As people call it.
    fn name(&self) -> String {
        if self.times == 1 { self.method.into() } else { format!("{} x{}", self.method, self.times) }
    }

    /// Energy that the scheme makes, relative to what there was.
    fn made(&self) -> Option<f64> {
        self.balance.filter(|b| b.peak > 0.0).map(|b| (b.source.abs() + b.residual.abs()) / b.peak)
    }
}

/// Runs the command.
pub fn run(args: &AccuracyArgs) -> Outcome {
    args.output.as_deref().map_or(Ok(()), page::is_page)?;
    let loaded = load::load(&args.source)?;
    let probes = if args.probe.is_empty() { heard(&loaded.model) } else { args.probe.clone() };
    if probes.is_empty() {
        let what = format!("`{}` has no output to compare", loaded.name);
        return Err(Failure::Failed(format!("{what}; name what to listen to by `--probe`")));
    }
    let scene =
        load::scene(&loaded, &Options { rate: args.source.rate, probes: probes.clone(), ..Options::default() })?;
    let rate = scene.rate;
    let seconds = args.seconds.unwrap_or_else(|| scene.seconds.unwrap_or(LONGEST).min(LONGEST));
    let frames = (seconds * rate).round().max(16.0) as usize;
    let mut times = args.times.clone();
    times.sort_unstable();
    times.dedup();
    let (all, refused) = ways(&loaded, &probes, rate, &times);
    let bar = term::progress(all.len() as u64 + 1);
    bar.tick();
    let truth = truth::truth(&loaded, &probes, &scene, frames, args.reference)?;
    bar.inc(1);
    if truth.columns.iter().flatten().all(|v| *v == 0.0) {
        bar.finish_and_clear();
        let what = format!("nothing of {} moves in {seconds} s", load::ticked(probes.iter().map(String::as_str)));
        return Err(Failure::Failed(format!(
            "{what}; play longer with `--seconds`, or listen elsewhere with `--probe`"
        )));
    }
    let mut rows = Vec::with_capacity(all.len());
    for way in &all {
        rows.push(measure(way, &truth, frames, rate)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    mark(&mut rows);
    let best = args.error.and_then(|e| recommended(&rows, e.max(truth.known)));
    let told = Told { loaded: &loaded, rows: &rows, truth: &truth, rate, frames, refused: &refused, best };
    if args.json {
        writeln!(std::io::stdout().lock(), "{:#}", told.json())?;
    } else {
        told.text(args.error)?;
    }
    if let Some(path) = &args.output {
        page::write(path, &told.page().html())?;
        term::note(&format!("the page is `{}`", path.display()));
    }
    Ok(if args.error.is_some() && best.is_none() { Ended::Degraded } else { Ended::Well })
}

/// What the outputs of a model listen to, once each.
fn heard(model: &Model) -> Vec<String> {
    let outputs = model.items.iter().filter(|i| matches!(i.kind.as_str(), "SOX" | "SOF"));
    let mut all = Vec::new();
    for e in outputs.flat_map(|i| i.args.iter().filter(|e| e.key == "from")) {
        if let Value::Text(t) = &e.value {
            if !all.contains(t) {
                all.push(t.clone());
            }
        }
    }
    all
}

/// Plays a way, scores it, and times it.
fn measure(way: &Way, truth: &Truth, frames: usize, rate: f64) -> Result<Row, Failure> {
    let (columns, mut ns) = play::columns(&way.scene, frames, way.times)?;
    for _ in 1..REPEATS {
        ns = ns.min(play::columns(&way.scene, frames, way.times)?.1);
    }
    let balance = way.audited.as_ref().and_then(|s| play::book(s, frames as u64 * u64::from(way.times)));
    Ok(Row {
        method: way.method,
        times: way.times,
        score: score::score(&columns, &truth.columns, rate),
        ns,
        level: way.scene.certificate.level,
        balance,
        front: false,
    })
}

/// Marks what nothing beats in both error and time.
fn mark(rows: &mut [Row]) {
    for i in 0..rows.len() {
        let (e, t) = (rows[i].score.error, rows[i].ns);
        let beaten = rows
            .iter()
            .enumerate()
            .any(|(j, r)| j != i && r.score.error <= e && r.ns <= t && (r.score.error < e || r.ns < t));
        rows[i].front = e.is_finite() && !beaten;
    }
}

/// The cheapest way with at most this error; among those that are not known to be unstable.
fn recommended(rows: &[Row], error: f64) -> Option<&Row> {
    let good = rows.iter().filter(|r| r.score.error <= error && r.level != Level::Unstable);
    good.min_by(|a, b| a.ns.total_cmp(&b.ns))
}

/// What is said of it all.
struct Told<'a> {
    loaded: &'a Loaded,
    rows: &'a [Row],
    truth: &'a Truth,
    rate: f64,
    frames: usize,
    refused: &'a [(&'static str, String)],
    /// what meets the error that was asked for
    best: Option<&'a Row>,
}

/// A number in a table.
fn small(v: f64) -> String {
    if v.is_finite() { format!("{v:.1e}") } else { "-".into() }
}

impl Told<'_> {
    fn origin(&self) -> String {
        let known = self.truth.known;
        match self.truth.origin {
            Origin::Modes => format!("the closed form of its modes, known to {known:.0e}"),
            Origin::Rate(n, p) => {
                format!("the model at {n} times the rate, converging with order {p:.1}, known to {known:.0e}")
            }
            Origin::Open(n) => {
                format!("the model at {n} times the rate, which does not converge evenly: known to {known:.0e}")
            }
        }
    }

    fn seconds(&self) -> f64 {
        self.frames as f64 / self.rate
    }

    fn cells(&self, r: &Row) -> Vec<String> {
        let under = r.score.error < self.truth.known;
        vec![
            if r.front { format!("{} *", r.name()) } else { r.name() },
            if under { format!("<{}", small(self.truth.known)) } else { small(r.score.error) },
            small(r.score.spectrum),
            r.score.cents.filter(|c| c.is_finite()).map_or("-".into(), |c| format!("{c:+.3}")),
            if r.score.error.is_finite() { format!("{:+.3}", r.score.decay) } else { "-".into() },
            r.made().map_or("-".into(), small),
            format!("{:.0}", r.ns),
            format!("{:.2}", 1e9 / (r.ns * self.rate)),
            r.level.to_string(),
        ]
    }

    const HEAD: [&'static str; 9] =
        ["method", "error", "spectrum", "cents", "decay dB", "made", "ns/sample", "x real time", "stability"];

    fn verdict(&self, asked: f64) -> String {
        match self.best {
            Some(r) => format!("the cheapest with an error of at most {asked:.0e}: {}", r.name()),
            None => format!("none of these has an error of at most {asked:.0e}; try more of `--times`"),
        }
    }

    fn text(&self, asked: Option<f64>) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        writeln!(out, "{}: {:.3} s at {} Hz, against {}", self.loaded.name, self.seconds(), self.rate, self.origin())?;
        let cells: Vec<Vec<String>> = self.rows.iter().map(|r| self.cells(r)).collect();
        let wide =
            |k: usize| cells.iter().map(|c| c[k].chars().count()).chain([Self::HEAD[k].len()]).max().unwrap_or(0);
        let line = |row: &[&str]| {
            let all = row
                .iter()
                .enumerate()
                .map(|(k, c)| if k == 0 || k == 8 { format!("{c:<0$}", wide(k)) } else { format!("{c:>0$}", wide(k)) });
            format!("  {}", all.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
        };
        writeln!(out, "{}", line(&Self::HEAD))?;
        for row in &cells {
            writeln!(out, "{}", line(&row.iter().map(String::as_str).collect::<Vec<_>>()))?;
        }
        writeln!(out, "  * nothing here is both more exact and quicker")?;
        for (method, why) in self.refused {
            writeln!(out, "  not by {method}: {why}")?;
        }
        if let Some(asked) = asked {
            writeln!(out, "{}", self.verdict(asked))?;
        }
        Ok(())
    }

    fn json(&self) -> Json {
        let finite = |v: f64| if v.is_finite() { json!(v) } else { Json::Null };
        let rows: Vec<Json> = self
            .rows
            .iter()
            .map(|r| {
                json!({
                    "method": r.method, "times": r.times, "error": finite(r.score.error),
                    "spectrum_error": finite(r.score.spectrum), "cents": r.score.cents.map(finite),
                    "decay_db": finite(r.score.decay), "made": r.made().map(finite), "ns_per_sample": r.ns,
                    "real_time_factor": 1e9 / (r.ns * self.rate), "stability": r.level.to_string(), "front": r.front,
                })
            })
            .collect();
        let (origin, times, order) = match self.truth.origin {
            Origin::Modes => ("modes", None, None),
            Origin::Rate(n, p) => ("rate", Some(n), Some(p)),
            Origin::Open(n) => ("open", Some(n), None),
        };
        json!({
            "name": self.loaded.name, "rate": self.rate, "seconds": self.seconds(), "rows": rows,
            "reference": { "origin": origin, "times": times, "order": order, "known": self.truth.known },
            "refused": self.refused.iter().map(|(m, why)| json!({ "method": m, "why": why })).collect::<Vec<_>>(),
            "recommended": self.best.map(|r| json!({ "method": r.method, "times": r.times })),
        })
    }

    /// The page: the plot, then the table.
    fn page(&self) -> Report {
        let subtitle = format!("{:.3} s at {} Hz, against {}", self.seconds(), self.rate, self.origin());
        let mut report = Report::new(&format!("{}: error against run time", self.loaded.name), &subtitle);
        let points: Vec<Point> = self
            .rows
            .iter()
            .map(|r| Point { name: r.name(), x: r.ns, y: r.score.error.max(self.truth.known), front: r.front })
            .collect();
        let (x, y) = (Axis::log("time of a sample", "ns"), Axis::log("error", ""));
        let plot = Plot::scatter("Error against run time", x, y, "not beaten", "others", &points);
        let table = Table::new(&Self::HEAD, self.rows.iter().map(|r| self.cells(r)).collect());
        report.sections.push(Section::new("Error against run time", vec![Block::Plot(plot), Block::Table(table)]));
        let refused = self.refused.iter().map(|(m, why)| vec![(*m).to_owned(), why.clone()]).collect::<Vec<_>>();
        if !refused.is_empty() {
            report.sections.push(Section::new(
                "Methods this model cannot take",
                vec![Block::Table(Table::new(&["method", "why"], refused))],
            ));
        }
        let source = Block::Source(self.loaded.model.file.clone(), self.loaded.model.text.clone());
        report.sections.push(Section::new("The model", vec![source]));
        report
    }
}
