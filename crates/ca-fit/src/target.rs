//! Recording that a model is fitted to: its onset, and the part that is compared.
//!
//! The model is compiled at the rate of the recording. If both have the same number of channels, these are compared one
//! by one; otherwise both are mixed to one channel. The compared part begins shortly before the onset, since silence
//! determines nothing. Sound after the fitted part is stored to check predictions.

use ca_io::recording::Recording;
use ca_lab::Failure;

/// The onset is the first sample louder than this fraction of the peak, which excludes handling noise before a pluck …
const LOUD: f64 = 0.1;
/// … that is followed by this fraction of the greatest power, which excludes a knock before a note: it decays at once.
const POWER: f64 = 0.04;
/// Time over which that power is measured \[s\].
const HELD: f64 = 0.06;
/// Time before the onset that is compared too \[s\].
const BEFORE: f64 = 0.01;
/// Least duration of sound from the onset \[s\].
pub(super) const LEAST: f64 = 0.05;
/// Longest part that is fitted by default \[s\].
const MOST: f64 = 4.0;
/// Time stored after the fitted part, unless that part is longer \[s\].
const AFTER: f64 = 2.0;
/// Sound more than this time before the onset counts as background noise \[s\].
const QUIET: f64 = 0.03;

pub(super) type Samples = Vec<Vec<f64>>;

/// Part of a recording that is compared.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    pub rate: f64,
    /// Samples from shortly before the onset.
    pub samples: Samples,
    /// Background noise before the onset.
    pub quiet: Samples,
    /// Index of the first of `samples` in the recording.
    pub begin: usize,
    /// Index of the onset in `samples`.
    pub onset: usize,
    /// Number of samples that are fitted.
    pub fitted: usize,
}

/// Returns the index of the onset; `None` for silence.
pub(super) fn onset(samples: &Samples, rate: f64) -> Option<usize> {
    let loudest = samples.iter().flatten().fold(0.0_f64, |m, v| m.max(v.abs()));
    let n = samples.first().map_or(0, Vec::len);
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    for i in 0..n {
        sum += samples.iter().map(|c| c[i] * c[i]).sum::<f64>();
        sums.push(sum);
    }
    let held = (HELD * rate) as usize;
    let power = |i: usize| sums[(i + held).min(n)] - sums[i];
    let most = (0..n).map(power).fold(0.0, f64::max);
    let loud = |i: &usize| samples.iter().any(|c| c[*i].abs() > LOUD * loudest);
    (0..n).filter(loud).find(|i| power(*i) >= POWER * most).filter(|_| loudest > 0.0)
}

pub(super) fn mixed(samples: &Samples) -> Samples {
    let n = samples.iter().map(Vec::len).min().unwrap_or(0);
    let part = 1.0 / samples.len().max(1) as f64;
    vec![(0..n).map(|i| part * samples.iter().map(|c| c[i]).sum::<f64>()).collect()]
}

impl Target {
    /// Prepares a recording for a model with `channels` channels; `seconds` from the onset are fitted.
    ///
    /// # Errors
    /// [`Failure::Failed`] where it is silent or too short.
    pub fn of(recording: &Recording, channels: usize, seconds: Option<f64>) -> Result<Target, Failure> {
        let Recording { rate, channels: all } = recording;
        let samples = if all.len() == channels { all.clone() } else { mixed(all) };
        let Some(at) = onset(&samples, *rate) else {
            let what = "the target is silent: all compared samples are 0";
            return Err(Failure::Failed(format!("{what}; use another recording")));
        };
        let begin = at.saturating_sub((BEFORE * rate) as usize);
        let silence = at.saturating_sub((QUIET * rate) as usize);
        let quiet: Samples = samples.iter().map(|c| c[..silence].to_vec()).collect();
        let mut samples: Samples = samples.into_iter().map(|c| c[begin..].to_vec()).collect();
        let (onset, there) = (at - begin, samples.first().map_or(0, Vec::len));
        let sound = (there - onset) as f64 / rate;
        if sound < LEAST {
            let what =
                format!("the target has {sound:.4} s of sound after its onset, but at least {LEAST} s are needed");
            return Err(Failure::Failed(format!("{what}; use a longer recording")));
        }
        let asked = seconds.unwrap_or(MOST).max(LEAST);
        let fitted = there.min(onset + (asked * rate) as usize);
        let end = fitted + (fitted - onset).max((AFTER * rate) as usize);
        for c in &mut samples {
            c.truncate(end);
        }
        Ok(Target { rate: *rate, samples, quiet, begin, onset, fitted })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_knock_before_a_note_is_no_onset() {
        let note = |i: usize| if i < 4000 { 0.0 } else { (-1e-4 * (i - 4000) as f64).exp() * (0.3 * i as f64).sin() };
        let mut sound: Samples = vec![(0..12_000).map(note).collect()];
        let begin = onset(&sound, 8000.0).unwrap();
        assert!((4000..4010).contains(&begin), "{begin}");
        (1000..1010).for_each(|i| sound[0][i] = 0.5);
        assert_eq!(onset(&sound, 8000.0), Some(begin));
        assert_eq!(onset(&vec![vec![0.0; 100]], 8000.0), None);
    }
}
