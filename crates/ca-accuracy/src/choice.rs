//! Chooses how to compute a model: the cheapest method and rate whose error is small enough and whose stability is proven.

use crate::methods::changes;
use crate::single::SINGLE;
use crate::{AccuracyOptions, Measured, MethodRow, measured};
use ca_core::Level;
use ca_lab::Failure;
use ca_lab::load::Loaded;

/// A way to compute a model that meets an error.
pub struct Choice {
    /// Its row.
    pub name: String,
    /// The numbers of the model that make it so, as names and values of `--set`; empty if the model stays as it is.
    pub changes: Vec<(String, String)>,
    /// Relative RMS error.
    pub error: f64,
    /// Relative error of the reference.
    pub known: f64,
    /// Time of a sample \[ns\].
    pub ns: f64,
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Stability.
    pub level: Level,
}

impl Measured {
    /// Returns the cheapest row of double precision with at most this error whose stability is proven, or else the
    /// cheapest whose linear part is. `None` if there is none, or if the reference is not known as well.
    pub fn choose(&self, error: f64) -> Option<&MethodRow> {
        if self.reference.known > error {
            return None;
        }
        self.cheapest(error, Level::Proven).or_else(|| self.cheapest(error, Level::Linearised))
    }

    fn cheapest(&self, error: f64, most: Level) -> Option<&MethodRow> {
        let rows = self.rows.iter().filter(|r| r.method != SINGLE && r.score.error <= error && r.level <= most);
        rows.min_by(|a, b| a.ns.total_cmp(&b.ns))
    }
}

/// Measures a model, and chooses how to compute it with at most this relative RMS error.
///
/// # Errors
/// Errors of [`measured`], and [`Failure::Failed`] if no row meets the error.
pub fn choose(loaded: &Loaded, error: f64, ask: &mut AccuracyOptions) -> Result<Choice, Failure> {
    let found = measured(loaded, ask)?;
    let Some(row) = found.choose(error) else {
        let best =
            found.rows.iter().filter(|r| r.method != SINGLE).min_by(|a, b| a.score.error.total_cmp(&b.score.error));
        let known = found.reference.known;
        let why = match best {
            _ if known > error => format!("the reference is accurate only to {known:.1e}"),
            Some(r) if r.score.error <= error => {
                format!("{} has an error of {:.1e}, but is {}", r.name(), r.score.error, r.level)
            }
            Some(r) => format!("the best is {}, with an error of {:.1e}", r.name(), r.score.error),
            None => "nothing was measured".into(),
        };
        return Err(Failure::Failed(format!(
            "no method that is proven has an error of at most {error:e}: {why}; allow a larger error"
        )));
    };
    let changes = changes(loaded, row.method, row.times).unwrap_or_default();
    let (error, known, rate) = (row.score.error, found.reference.known, found.rate);
    Ok(Choice { name: row.name(), changes, error, known, ns: row.ns, rate, level: row.level })
}

impl Choice {
    /// Describes the choice in a line: error beside run time.
    pub fn words(&self) -> String {
        let Choice { name, error, known, ns, rate, level, .. } = self;
        let error = if error < known { format!("below {known:.1e}") } else { format!("{error:.1e}") };
        format!("{name}: error {error}, {ns:.0} ns per sample, {:.1} times real time, {level}", 1e9 / (ns * rate))
    }
}
