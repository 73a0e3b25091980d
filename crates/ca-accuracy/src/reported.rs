//! The result of `ca accuracy` for a model: as JSON, as a verdict, and as a page.

use crate::{Measured, MethodRow, Origin};
use ca_model::Model;
use ca_report::{Block, Report, Section};
use serde_json::{Value as Json, json};

/// A measurement of a model, and the row that meets an error.
pub struct Reported<'a> {
    /// Name of the model.
    pub name: &'a str,
    /// Measurement.
    pub found: &'a Measured,
    /// Fastest row within the requested error.
    pub best: Option<&'a MethodRow>,
    asked: Option<f64>,
    dashes: &'static str,
}

impl<'a> Reported<'a> {
    /// Finds the fastest row within the requested relative RMS error, if there is one. `dashes` begins the name of an
    /// option in messages: `--` in a command, otherwise nothing.
    pub fn new(name: &'a str, found: &'a Measured, asked: Option<f64>, dashes: &'static str) -> Reported<'a> {
        Reported { name, found, best: asked.and_then(|error| found.choose(error)), asked, dashes }
    }

    /// Says whether a row meets the requested error.
    pub fn verdict(&self) -> Option<String> {
        let (asked, reference) = (self.asked?, &self.found.reference);
        let dashes = self.dashes;
        let (known, error_target) = (reference.known, format!("an error of at most {asked:e}"));
        Some(match (self.best, reference.origin) {
            (Some(r), _) => format!("fastest with {error_target}: {}", r.name()),
            (None, _) if known <= asked => {
                format!("no row that is proven has {error_target}; try larger multiples with `{dashes}times`")
            }
            (None, Origin::Modes) => {
                format!(
                    "{error_target} cannot be confirmed: the closed form is accurate only to {known:.1e}; choose a larger \
                     `{dashes}error`"
                )
            }
            (None, Origin::Rate(n, _) | Origin::Open(n)) => {
                format!(
                    "{error_target} cannot be confirmed: the reference is accurate only to {known:.1e}; raise \
                     `{dashes}reference` above {n}"
                )
            }
        })
    }

    /// Returns all rows and the reference.
    pub fn json(&self) -> Json {
        let f = self.found;
        let finite = |v: f64| if v.is_finite() { json!(v) } else { Json::Null };
        let rows: Vec<Json> = f
            .rows
            .iter()
            .map(|r| {
                json!({
                    "method": r.method, "times": r.times, "error": finite(r.score.error),
                    "spectrum_error": finite(r.score.spectrum), "cents": r.score.cents.map(finite),
                    "decay_db": finite(r.score.decay), "made": r.energy_error().map(finite), "ns_per_sample": r.ns,
                    "real_time_factor": 1e9 / (r.ns * f.rate), "stability": r.level.to_string(), "front": r.front,
                })
            })
            .collect();
        let (origin, times, order) = match f.reference.origin {
            Origin::Modes => ("modes", None, None),
            Origin::Rate(n, p) => ("rate", Some(n), Some(p)),
            Origin::Open(n) => ("open", Some(n), None),
        };
        json!({
            "name": self.name, "rate": f.rate, "seconds": f.seconds(), "rows": rows,
            "reference": { "origin": origin, "times": times, "order": order, "known": f.reference.known,
                           "method": f.reference.method, "agrees": f.reference.second.map(|s| s.agrees),
                           "second": f.reference.second.map(|s| s.method), "apart": f.reference.second.map(|s| s.apart),
                           "words": f.origin() },
            "refused": f.refused.iter().map(|(m, why)| json!({ "method": m, "why": why })).collect::<Vec<_>>(),
            "warned": f.warned.iter().map(|(m, what)| json!({ "method": m, "what": what })).collect::<Vec<_>>(),
            "recommended": self.best.map(|r| json!({ "method": r.method, "times": r.times })),
            "verdict": self.verdict(),
        })
    }

    /// Returns the page with plot, table and model.
    pub fn page(&self, model: &Model) -> Report {
        let mut report = Report::new(&format!("{}: error against run time", self.name), "");
        report.sections.push(self.found.section(self.best.map(|r| (r, "chosen"))));
        report.sections.push(Section::new("The model", vec![Block::Source(model.file.clone(), model.text.clone())]));
        report
    }
}
