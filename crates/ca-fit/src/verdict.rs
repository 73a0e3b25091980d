//! Judges a fit: did the search settle, at the pitch of the recording, and does the model explain the sound?
//!
//! Deviations are not reported where one of these fails. Derivatives give one even at a point that is not a minimum, or
//! for a model that makes another sound, and a small one if the recording is long. The same holds in another minimum:
//! the fit is in one if the model ends at another pitch than the recording, and may be in one if it started more than a
//! semitone away, unless samples agree.

use super::{Distance, Fit, Pitch, Stage};
use ca_model::quantity::{Plain, rounded};

/// Greatest level difference that counts as the same sound \[dB\]; twelve guitar strings are fitted to 6.5 dB or less.
const LEVELS: f64 = 6.6;
/// Greatest sample residual that counts as the same sound \[dB\].
const SAMPLES: f64 = -3.0;
/// Smallest improvement that counts as one \[dB\].
const LITTLE: f64 = 0.1;
/// Sample residual below which a fit cannot improve \[dB\].
const ALIKE: f64 = -60.0;

/// Names of the options of a fit, for its messages.
#[derive(Debug)]
pub struct Words {
    /// Range of a number.
    pub range: &'static str,
    /// Initial value of a number.
    pub set: &'static str,
    /// Maximum number of renders.
    pub renders: &'static str,
    /// Time to fit.
    pub seconds: &'static str,
}

impl Words {
    /// Names in the command.
    pub const COMMAND: Words =
        Words { range: "`--range`", set: "`--set`", renders: "`--renders`", seconds: "`--seconds`" };
    /// Names in Python.
    pub const PYTHON: Words =
        Words { range: "`ranges`", set: "`Scene.replace`", renders: "`renders`", seconds: "`seconds`" };
}

/// Reason for the end of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The next step would change every number by less than its deviation.
    Settled,
    /// Too few renders were left for another step.
    Renders,
    /// The next step would change numbers by more, but every step tried failed to come nearer.
    Stuck,
}

/// Result of a search besides its point.
pub(super) struct Known {
    /// Standard deviations of the search coordinates; `None` where a number is not determined.
    pub deviations: Vec<Option<f64>>,
    pub halt: StopReason,
}

impl Known {
    /// Result for `n` numbers without an estimate, not even whether the sound determines them.
    pub fn nothing(n: usize) -> Known {
        Known { deviations: vec![Some(f64::INFINITY); n], halt: StopReason::Renders }
    }
}

/// Reason for a missing deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The sound does not determine the number.
    Undetermined,
    /// The search did not settle.
    Unsettled,
    /// The model does not explain the sound.
    Unexplained,
    /// The model ends at another pitch than the recording.
    Elsewhere,
    /// The model started at another pitch, and samples do not tell whether that matters.
    Far,
}

/// Returns whether the residuals are so small that this model may have made the sound.
pub(super) fn explained(left: &Distance) -> bool {
    left.levels <= LEVELS || left.samples <= SAMPLES
}

impl Fit {
    /// Returns whether the model came nearer to the recording: by more than 0.1 dB in the distance that determined the
    /// result, and not much farther in the other. A start that equals the recording counts as nearer.
    pub fn is_nearer(&self) -> bool {
        nearer(&self.before, &self.after, self.stage)
    }

    /// Returns whether the model ends at another pitch than the recording.
    pub fn is_elsewhere(&self) -> bool {
        self.pitch.ends_elsewhere()
    }

    /// Warnings about the values, one sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = Vec::new();
        let Words { range, set, renders, seconds } = self.words;
        for f in &self.fitted {
            let name = &f.varied.name;
            if f.at_end {
                all.push(format!(
                    "`{name}` is at an end of its range; if values beyond it are possible, widen it with {range}"
                ));
            }
            if f.doubt == Some(Doubt::Undetermined) {
                all.push(format!("`{name}` is not determined by this sound; do not rely on its value"));
            }
        }
        all.extend(self.of_pitch(set));
        if !self.explained {
            let Distance { levels, samples } = self.after;
            let left = format!("level difference {levels:.1} dB, sample residual {samples:.1} dB");
            let what = format!("the model does not explain this sound ({left}), so no deviations are given");
            all.push(format!("{what}; vary other numbers, start from closer values with {set}, or change the model"));
        }
        match self.halt {
            StopReason::Settled => {}
            StopReason::Renders => {
                let what =
                    format!("the search did not converge within {} renders, so no deviations are given", self.renders);
                all.push(format!("{what}; allow more with {renders}, or start from closer values with {set}"));
            }
            StopReason::Stuck => {
                let what =
                    "the search stopped without convergence: no step reduced the distance, so no deviations are given";
                all.push(format!(
                    "{what}; start from other values with {set}, or fit more of the sound with {seconds}"
                ));
            }
        }
        if !self.is_nearer() {
            let what = "the fit did not bring the model closer to the recording";
            all.push(format!("{what}; vary other numbers, or start from other values with {set}"));
        }
        all
    }

    fn of_pitch(&self, set: &str) -> Option<String> {
        let Pitch { recording, start, found, from_start, left } = self.pitch;
        let hertz = |f: Option<f64>| f.map_or_else(String::new, |f| format!("{} Hz", Plain(rounded(f, 4))));
        let (far, of) = if self.pitch.ends_elsewhere() { (left, found) } else { (from_start, start) };
        let way = if far > 0.0 { "below" } else { "above" };
        let far =
            format!("{:.1} semitones {way} the recording ({}, {})", far.abs() / 100.0, hertz(of), hertz(recording));
        if self.pitch.ends_elsewhere() {
            let what = format!(
                "the search ended in another local minimum: the fitted model is {far}, so no deviations are given"
            );
            return Some(format!("{what}; start from closer values with {set}"));
        }
        let certain = self.stage == Stage::Samples;
        let what = if certain {
            "the samples agree nevertheless"
        } else {
            "the search may have ended in another local minimum, so no deviations are given"
        };
        self.pitch.starts_far().then(|| format!("the model starts {far}: {what}; start from closer values with {set}"))
    }
}

fn nearer(was: &Distance, is: &Distance, stage: Stage) -> bool {
    if is.samples < ALIKE {
        return true;
    }
    match stage {
        // samples that were not explained before do not count
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
