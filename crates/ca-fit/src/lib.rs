//! `ca fit`: numbers of a model found by a recorded sound.
//!
//! Decides for three distances, one after the other, since each is only good near its end. The modes of the linear part are
//! brought to the partials of the recording, without a render; then levels in windows of several lengths, which do not mind
//! phases; then the samples themselves, in windows that grow as far as phases agree. What samples cannot follow (a recording that
//! is none of ours) keeps the values of the levels. Gain and delay are unknowns of each comparison.
//!
//! The uncertainty is that of the distance that decided, from the derivatives at the end and what is left, stretch of
//! time by stretch of time: a recording differs from a model by what hangs together over milliseconds, and a count of samples
//! would promise digits that nobody can have.
//! The fit to shorter windows of time checks it.

#![forbid(unsafe_code)]

mod loss;
mod modal;
mod normal;
mod page;
mod pitch;
mod player;
mod search;
mod settle;
mod sinusoids;
mod summary;
mod target;
#[cfg(test)]
mod tests;
pub mod tune;
mod vary;
mod verdict;
mod work;

pub use page::report;
pub use pitch::Pitch;
pub use vary::{Range, Varied};
pub use verdict::{Doubt, StopReason, Words};

use ca_compile::Options;
use ca_io::gesture::Gesture;
use ca_io::recording::Recording;
use ca_lab::Failure;
use ca_lab::Loaded;
use player::Player;
use target::{Samples, Target};
use work::Work;

/// Fewest renders with which something can be found, beside two for each number.
const FEW: u32 = 4;
/// Least time beyond what is fitted that says something \[s\].
const BEYOND: f64 = 0.1;

/// What is asked.
pub struct FitOptions<'a> {
    /// names of numbers, as `--set` knows them
    pub vary: &'a [String],
    /// ranges of some of them
    pub ranges: &'a [Range],
    /// how much of the recording is fitted, from its onset on \[s\]; up to four seconds if none
    pub seconds: Option<f64>,
    /// gain of the model in the recording; free if none
    pub gain: Option<f64>,
    /// most renders
    pub renders: u32,
    /// what plays the model, beside its own gesture
    pub gesture: Option<&'a Gesture>,
    /// what options are called where they are named
    pub words: &'static Words,
    /// called before each render with how many there have been and may be; `false` ends it
    pub progress: &'a mut dyn FnMut(u32, u32) -> bool,
}

/// A number that was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// what
    pub varied: Varied,
    /// its value
    pub value: f64,
    /// one standard deviation, in its unit; `None` where there is a doubt
    pub deviation: Option<f64>,
    /// why there is no deviation
    pub doubt: Option<Doubt>,
    /// whether it is at an end of its range
    pub at_end: bool,
}

/// How far the model is from the recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// root mean square of the differences of levels \[dB\]
    pub levels: f64,
    /// what is left of the samples, beside the recording \[dB\]
    pub samples: f64,
}

/// Distances of a time that was not fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// how long \[s\]
    pub seconds: f64,
    /// of the model
    pub model: Distance,
    /// of damped sinusoids with as many free numbers or more, which were fitted to the same time as the model
    pub sinusoids: Distance,
    /// how many sinusoids
    pub count: usize,
}

impl Beyond {
    /// The sinusoids in words.
    pub fn named(&self) -> String {
        format!("{} damped sinusoid{}", self.count, if self.count == 1 { "" } else { "s" })
    }
}

/// Which distance decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// levels
    Levels,
    /// samples
    Samples,
}

/// What was found.
pub struct Fit {
    /// the model with the values found
    pub loaded: Loaded,
    /// the numbers
    pub fitted: Vec<Fitted>,
    /// gain of the model in the recording
    pub gain: f64,
    /// its delay there \[s\]
    pub delay: f64,
    /// renders
    pub renders: u32,
    /// which distance decided
    pub stage: Stage,
    /// seconds of the recording in which samples were compared
    pub phase: f64,
    /// seconds that were fitted
    pub seconds: f64,
    /// why the search ended
    pub halt: StopReason,
    /// whether so little is left that the sound may be one of this model
    pub explained: bool,
    /// pitches of the recording and of the model
    pub pitch: Pitch,
    /// distance before
    pub before: Distance,
    /// and after
    pub after: Distance,
    /// that of what was not fitted, where there is enough of it
    pub beyond: Option<Beyond>,
    /// what is heard, to be shown
    shown: Shown,
    words: &'static Words,
}

/// The three sounds of a fit, as they are compared.
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
/// [`Failure::Usage`] where a number cannot be varied, [`Failure::Found`] where the model has errors at this rate,
/// [`Failure::Failed`] where the recording or the model is silent, [`Failure::Stopped`] where `progress` says so.
pub fn fit(loaded: &Loaded, recording: &Recording, ask: &mut FitOptions) -> Result<Fit, Failure> {
    if ask.vary.is_empty() {
        return Err(Failure::Usage("nothing is varied; name a number, such as `low.f`".into()));
    }
    let mut varied: Vec<Varied> = Vec::new();
    for name in ask.vary {
        if varied.iter().any(|v| v.name == *name) {
            return Err(Failure::Usage(format!("`{name}` is named twice")));
        }
        varied.push(Varied::of(loaded, name, ask.ranges, ask.words)?);
    }
    if let Some(r) = ask.ranges.iter().find(|r| !ask.vary.contains(&r.name)) {
        return Err(Failure::Usage(format!("`{}` has a range and is not varied", r.name)));
    }
    if ask.gain.is_some_and(|gain| gain == 0.0 || !gain.is_finite()) {
        return Err(Failure::Usage("the gain is a number other than 0".into()));
    }
    let n = varied.len() as u32;
    if ask.renders < FEW + 2 * n {
        let what = format!("{} renders are too few for {n} number{}", ask.renders, if n == 1 { "" } else { "s" });
        return Err(Failure::Usage(format!("{what}: {} or more", FEW + 2 * n)));
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
