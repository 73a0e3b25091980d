//! The recording that a model is fitted to: where its sound begins, and what of it is compared.
//!
//! Decides that a recording keeps its rate, and the model is compiled at it. As many channels as the model has are compared one
//! by one; of any other number both sides are mixed into one. What is compared begins shortly before the onset: of silence
//! nothing is learned. What is beyond the part that is fitted is kept, since it tells whether the fit predicts.

use crate::Failure;
use ca_io::recording::Recording;

/// The onset is the first sample louder than this part of the loudest: above what is heard of a hand before it plucks.
const LOUD: f64 = 0.1;
/// So much before the onset is compared too \[s\].
const BEFORE: f64 = 0.01;
/// Least sound from the onset on \[s\].
pub(super) const LEAST: f64 = 0.05;
/// Most that is fitted where nobody says how much \[s\].
const MOST: f64 = 4.0;
/// What comes after that is kept for as long again, or for so long \[s\].
const AFTER: f64 = 2.0;
/// What is heard so long before the onset is the noise of the room \[s\].
const QUIET: f64 = 0.03;

/// Samples of each channel.
pub(super) type Samples = Vec<Vec<f64>>;

/// A recording, as far as it is compared.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    /// \[Hz\]
    pub rate: f64,
    /// from a little before the onset on
    pub samples: Samples,
    /// what was recorded before there was anything to hear
    pub quiet: Samples,
    /// where that begins in the recording
    pub begin: usize,
    /// the onset, from there on
    pub onset: usize,
    /// how many samples are fitted
    pub fitted: usize,
}

/// The first loud sample; `None` of silence.
pub(super) fn onset(samples: &Samples) -> Option<usize> {
    let loudest = samples.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let first = samples.iter().filter_map(|c| c.iter().position(|v| v.abs() > LOUD * loudest)).min();
    first.filter(|_| loudest > 0.0)
}

/// One channel of all.
pub(super) fn mixed(samples: &Samples) -> Samples {
    let n = samples.iter().map(Vec::len).min().unwrap_or(0);
    let part = 1.0 / samples.len().max(1) as f64;
    vec![(0..n).map(|i| part * samples.iter().map(|c| c[i]).sum::<f64>()).collect()]
}

impl Target {
    /// Of a recording, for a model with so many channels; `seconds` from the onset on are fitted.
    ///
    /// # Errors
    /// [`Failure::Failed`] where it is silent or too short.
    pub fn of(recording: &Recording, channels: usize, seconds: Option<f64>) -> Result<Target, Failure> {
        let Recording { rate, channels: all } = recording;
        let samples = if all.len() == channels { all.clone() } else { mixed(all) };
        let Some(at) = onset(&samples) else {
            let what = "the target is silent: no sample of it differs from 0";
            return Err(Failure::Failed(format!("{what}; record it louder, or name another file")));
        };
        let begin = at.saturating_sub((BEFORE * rate) as usize);
        let silence = at.saturating_sub((QUIET * rate) as usize);
        let quiet: Samples = samples.iter().map(|c| c[..silence].to_vec()).collect();
        let mut samples: Samples = samples.into_iter().map(|c| c[begin..].to_vec()).collect();
        let (onset, there) = (at - begin, samples.first().map_or(0, Vec::len));
        let sound = (there - onset) as f64 / rate;
        if sound < LEAST {
            let what = format!("the target has {sound:.4} s of sound from its onset on; at least {LEAST} s are needed");
            return Err(Failure::Failed(format!("{what}; record more of it")));
        }
        let asked = seconds.unwrap_or(MOST).max(LEAST);
        let fitted = there.min(onset + (asked * rate) as usize);
        let end = fitted + (fitted - onset).max((AFTER * rate) as usize);
        samples.iter_mut().for_each(|c| c.truncate(end));
        Ok(Target { rate: *rate, samples, quiet, begin, onset, fitted })
    }
}
