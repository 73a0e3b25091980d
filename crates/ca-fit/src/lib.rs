//! `ca fit`: finds numbers of a model from a recorded sound.
//!
//! Three distances are minimised in turn, since each works only near its minimum. First, the modes of the linear part
//! are matched to the partials of the recording, without a render. Then levels are compared in windows of several
//! lengths, which ignore phase; then samples, in windows that grow as far as phases agree. If samples cannot be
//! followed (a recording that no model made), the values from levels remain. Gain and delay are unknowns of each
//! comparison.
//!
//! The uncertainty follows from the last distance used: its derivatives at the end, and the residuals by stretches of
//! time. Residuals of a recording are correlated over milliseconds, and treating them as independent would give too
//! small a value. Fits to shorter windows of time check it.

#![forbid(unsafe_code)]

mod convergence;
mod loss;
mod modal;
mod normal_equations;
mod page;
mod pitch;
mod player;
mod search;
mod sinusoids;
mod stages;
mod summary;
mod target;
#[cfg(test)]
mod tests;
pub mod tune;
mod variables;
mod verdict;

pub use page::report;
pub use pitch::Pitch;
pub use variables::{Range, Varied};
pub use verdict::{Doubt, StopReason, Words};

use ca_compile::Options;
use ca_io::gesture::Gesture;
use ca_io::recording::Recording;
use ca_lab::Failure;
use ca_lab::Loaded;
use player::Player;
use stages::Work;
use target::{Samples, Target};

/// Least number of renders for a search, besides two for each number.
const FEW: u32 = 4;
/// Least time after the fitted part for which predictions are reported \[s\].
const BEYOND: f64 = 0.1;

/// Options of a fit.
pub struct FitOptions<'a> {
    /// Names of the numbers to vary, in the syntax of `--set`.
    pub vary: &'a [String],
    /// Ranges for some of them.
    pub ranges: &'a [Range],
    /// Time to fit, from the onset of the recording \[s\]; up to four seconds if `None`.
    pub seconds: Option<f64>,
    /// Gain of the model in the recording; free if `None`.
    pub gain: Option<f64>,
    /// Maximum number of renders.
    pub renders: u32,
    /// Gesture that plays the model, besides its own.
    pub gesture: Option<&'a Gesture>,
    /// Names of the options in messages.
    pub words: &'static Words,
    /// Called before each render with its number and the maximum; `false` stops the fit.
    pub progress: &'a mut dyn FnMut(u32, u32) -> bool,
}

/// Fitted number.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The number that was varied.
    pub varied: Varied,
    /// Its fitted value.
    pub value: f64,
    /// Standard deviation, in its unit; `None` where there is a doubt.
    pub deviation: Option<f64>,
    /// Reason for a missing deviation.
    pub doubt: Option<Doubt>,
    /// True at an end of its range.
    pub at_end: bool,
}

/// Distance of the model from the recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Root mean square of the level differences \[dB\].
    pub levels: f64,
    /// Power of the sample residuals relative to the recording \[dB\].
    pub samples: f64,
}

/// Distances over the time after the fitted part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Its length \[s\].
    pub seconds: f64,
    /// Distance of the model.
    pub model: Distance,
    /// Distance of damped sinusoids that were fitted to the same time, with at least as many free numbers.
    pub sinusoids: Distance,
    /// Number of sinusoids.
    pub count: usize,
}

impl Prediction {
    /// Describes the sinusoids in words.
    pub fn named(&self) -> String {
        format!("{} damped sinusoid{}", self.count, if self.count == 1 { "" } else { "s" })
    }
}

/// Distance that determined the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Levels.
    Levels,
    /// Samples.
    Samples,
}

/// Result of a fit.
pub struct Fit {
    /// The model with the values found.
    pub loaded: Loaded,
    /// The fitted numbers.
    pub fitted: Vec<Fitted>,
    /// Gain of the model in the recording.
    pub gain: f64,
    /// Delay of the model in the recording \[s\].
    pub delay: f64,
    /// Number of renders.
    pub renders: u32,
    /// Distance that determined the result.
    pub stage: Stage,
    /// Time of the recording in which samples were compared \[s\].
    pub phase: f64,
    /// Time fitted \[s\].
    pub seconds: f64,
    /// Reason for the end of the search.
    pub halt: StopReason,
    /// True if the residuals are so small that this model may have made the sound.
    pub explained: bool,
    /// Pitches of the recording and of the model.
    pub pitch: Pitch,
    /// Distance at the start.
    pub before: Distance,
    /// Distance at the end.
    pub after: Distance,
    /// Distances over the time after the fitted part, if there is enough of it.
    pub beyond: Option<Prediction>,
    shown: Shown,
    words: &'static Words,
}

/// Recording and model before and after, as they are compared.
struct Shown {
    rate: f64,
    fitted: usize,
    target: Samples,
    before: Samples,
    after: Samples,
}

/// Fits numbers of a model to a recording.
///
/// # Errors
/// [`Failure::Usage`] where a number cannot be varied; [`Failure::Found`] where the model has errors at this rate;
/// [`Failure::Failed`] where the recording or the model is silent; [`Failure::Stopped`] where `progress` returns false.
pub fn fit(loaded: &Loaded, recording: &Recording, ask: &mut FitOptions) -> Result<Fit, Failure> {
    if ask.vary.is_empty() {
        return Err(Failure::Usage("no number to vary; name at least one, such as `low.f`".into()));
    }
    let mut varied: Vec<Varied> = Vec::new();
    for name in ask.vary {
        if varied.iter().any(|v| v.name == *name) {
            return Err(Failure::Usage(format!("`{name}` is named twice; remove one of them")));
        }
        varied.push(Varied::of(loaded, name, ask.ranges, ask.words)?);
    }
    if let Some(r) = ask.ranges.iter().find(|r| !ask.vary.contains(&r.name)) {
        return Err(Failure::Usage(format!(
            "`{}` has a range but is not varied; vary it, or remove its range",
            r.name
        )));
    }
    if ask.gain.is_some_and(|gain| gain == 0.0 || !gain.is_finite()) {
        return Err(Failure::Usage("the gain must be a finite number other than 0".into()));
    }
    let n = varied.len() as u32;
    if ask.renders < FEW + 2 * n {
        let what = format!("{} renders are too few for {n} number{}", ask.renders, if n == 1 { "" } else { "s" });
        return Err(Failure::Usage(format!("{what}: allow {} or more", FEW + 2 * n)));
    }
    let options = Options { rate: Some(recording.rate), clouds: loaded.clouds.clone(), ..Options::default() };
    let scene = loaded.compile(&options)?;
    if scene.counts.channels == 0 {
        return Err(Failure::Failed("the model has no output to compare; add a `[SOX]`".into()));
    }
    let target = Target::of(recording, scene.counts.channels, ask.seconds)?;
    let channels = target.samples.len();
    let goes_on: &mut dyn FnMut(u32, u32) -> bool = &mut *ask.progress;
    let play = (recording.rate, channels, ask.renders);
    let mut player = Player::new(loaded, &varied, ask.gesture, play, goes_on);
    let (ends, gain, words) = (varied.iter().map(Varied::ends).collect(), ask.gain, ask.words);
    Work { target, varied: &varied, ends, gain, words }.run(&mut player)
}
