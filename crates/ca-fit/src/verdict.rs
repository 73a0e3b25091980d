//! Judges a fit: did the search settle, at the pitch of the recording, does the model explain the sound, and did it come nearer?
//!
//! Decides that no deviation is given where one of these fails: derivatives at a place that is no end of the search, or of a model
//! that makes another sound, give one all the same, and a small one where the recording is long. So do derivatives in another minimum: a model
//! that ends at another pitch than the recording is in one, and one that started more than a semitone away may be, unless the
//! samples agree.

use super::{Distance, Fit, Pitch, Stage};
use ca_model::quantity::{Plain, rounded};

/// Levels that are further off than this are those of another sound \[dB\]: twelve recorded guitar strings are fitted to 6.5 dB and less.
const LEVELS: f64 = 6.6;
/// … unless this much of the samples is explained \[dB\].
const SAMPLES: f64 = -3.0;
/// Less gained than this is no gain \[dB\].
const LITTLE: f64 = 0.1;
/// A sound of which so little is left cannot be improved \[dB\].
const ALIKE: f64 = -60.0;

/// Names of the options of a fit, for its messages.
#[derive(Debug)]
pub struct Words {
    /// how far a number goes
    pub range: &'static str,
    /// where it starts
    pub set: &'static str,
    /// most renders
    pub renders: &'static str,
    /// how much is fitted
    pub seconds: &'static str,
}

impl Words {
    /// Those of the command.
    pub const COMMAND: Words =
        Words { range: "`--range`", set: "`--set`", renders: "`--renders`", seconds: "`--seconds`" };
    /// Those of Python.
    pub const PYTHON: Words =
        Words { range: "`ranges`", set: "`Scene.replace`", renders: "`renders`", seconds: "`seconds`" };
}

/// Why the search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// what a step would still change is less than the deviations
    Settled,
    /// no renders were left for another step
    Renders,
    /// steps would still change numbers, and none that was tried gained anything
    Stuck,
}

/// What is known at the end of a search.
pub(super) struct Known {
    /// the standard deviations of places; `None` of what is not determined
    pub deviations: Vec<Option<f64>>,
    /// why it ended
    pub halt: StopReason,
}

impl Known {
    /// Of so many numbers, where nothing could be looked at: not even whether the sound determines them.
    pub fn nothing(n: usize) -> Known {
        Known { deviations: vec![Some(f64::INFINITY); n], halt: StopReason::Renders }
    }
}

/// Why a number has no deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// the sound does not determine it
    Undetermined,
    /// the search did not settle
    Unsettled,
    /// the model does not explain the sound
    Unexplained,
    /// the model ends at another pitch than the recording
    Elsewhere,
    /// it started at another pitch, and samples do not tell whether that matters
    Far,
}

/// Whether so little is left that the sound may be one of this model.
pub(super) fn explained(left: &Distance) -> bool {
    left.levels <= LEVELS || left.samples <= SAMPLES
}

impl Fit {
    /// Whether the model came nearer to the recording: by more than a little in the distance that decided, and not much farther
    /// in the other. A start that is the recording itself cannot be improved, and counts too.
    pub fn is_nearer(&self) -> bool {
        nearer(&self.before, &self.after, self.stage)
    }

    /// True if the model ends at another pitch than the recording.
    pub fn is_elsewhere(&self) -> bool {
        self.pitch.ends_elsewhere()
    }

    /// What somebody should know of the values, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = Vec::new();
        let Words { range, set, renders, seconds } = self.words;
        for f in &self.fitted {
            let name = &f.varied.name;
            if f.at_end {
                all.push(format!("`{name}` is at an end of its range; widen it with {range}, if it may go on"));
            }
            if f.doubt == Some(Doubt::Undetermined) {
                all.push(format!("`{name}` is not determined by this sound; its value says nothing"));
            }
        }
        all.extend(self.of_pitch(set));
        if !self.explained {
            let Distance { levels, samples } = self.after;
            let left = format!("levels {levels:.1} dB off, {samples:.1} dB of the samples left");
            let what = format!("the model does not explain this sound ({left}), so no deviations are given");
            all.push(format!("{what}; vary other numbers, start nearer with {set}, or change the model"));
        }
        match self.halt {
            StopReason::Settled => {}
            StopReason::Renders => {
                let what =
                    format!("the search did not settle within {} renders, so no deviations are given", self.renders);
                all.push(format!("{what}; allow more with {renders}, or start nearer with {set}"));
            }
            StopReason::Stuck => {
                let what = "the search stopped where no step came nearer and the values had not settled, so no deviations are given";
                all.push(format!("{what}; start elsewhere with {set}, or fit more of the sound with {seconds}"));
            }
        }
        if !self.is_nearer() {
            let what = "the model came no nearer to the recording";
            all.push(format!("{what}; vary other numbers, or start elsewhere with {set}"));
        }
        all
    }

    /// The warning about pitches.
    fn of_pitch(&self, set: &str) -> Option<String> {
        let Pitch { recording, start, found, from_start, left } = self.pitch;
        let hertz = |f: Option<f64>| f.map_or_else(String::new, |f| format!("{} Hz", Plain(rounded(f, 4))));
        let (far, of) = if self.pitch.ends_elsewhere() { (left, found) } else { (from_start, start) };
        let way = if far > 0.0 { "below" } else { "above" };
        let far =
            format!("{:.1} semitones {way} the recording ({}, {})", far.abs() / 100.0, hertz(of), hertz(recording));
        if self.pitch.ends_elsewhere() {
            let what =
                format!("the search stopped in another minimum: the model ends {far}, so no deviations are given");
            return Some(format!("{what}; start nearer with {set}"));
        }
        let certain = self.stage == Stage::Samples;
        let what = if certain {
            "the samples agree all the same"
        } else {
            "the search may have stopped in another minimum, so no deviations are given"
        };
        self.pitch.starts_far().then(|| format!("the model starts {far}: {what}; start nearer with {set}"))
    }
}

fn nearer(was: &Distance, is: &Distance, stage: Stage) -> bool {
    if is.samples < ALIKE {
        return true;
    }
    match stage {
        // samples that were not explained before have nothing to lose
        Stage::Levels => {
            let farther = was.samples <= SAMPLES && is.samples > was.samples - SAMPLES;
            is.levels < was.levels - LITTLE && !farther
        }
        Stage::Samples => is.samples < was.samples - LITTLE && is.levels < 1.25 * was.levels + 0.5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearer_is_more_than_a_little_and_not_farther_elsewhere() {
        let of = |levels: f64, samples: f64| Distance { levels, samples };
        for (was, is, stage, is_nearer) in [
            (of(13.65, -0.0), of(13.60, -0.1), Stage::Levels, false),
            (of(6.41, -2.1), of(6.15, -1.5), Stage::Levels, true),
            (of(83.6, 0.0), of(87.9, -0.5), Stage::Levels, false),
            (of(5.0, -9.0), of(4.0, -5.0), Stage::Levels, false),
            (of(5.0, -9.0), of(6.0, -20.0), Stage::Samples, true),
            (of(5.0, -9.0), of(9.0, -20.0), Stage::Samples, false),
            (of(5.0, -20.0), of(4.0, -20.01), Stage::Samples, false),
            (of(0.0, -90.0), of(0.0, -90.0), Stage::Samples, true),
        ] {
            assert_eq!(nearer(&was, &is, stage), is_nearer, "{was:?} {is:?}");
        }
        assert!(explained(&of(6.51, -0.2)) && explained(&of(20.0, -10.0)));
        assert!(!explained(&of(35.8, 0.0)) && !explained(&of(f64::NAN, f64::NAN)));
    }
}
