//! Distance of two sounds by samples.
//!
//! The gain follows in closed form at each comparison. A fractional delay is a windowed sinc, and a whole one moves
//! samples, so that a model with a delay of 0 is compared to the bit.

use super::{Free, Loss, STRETCHES};
use crate::normal_equations::dot;
use crate::target::{Samples, Target};

/// Samples of the sinc on either side.
const HALF: isize = 16;

pub(crate) struct Wave {
    target: Vec<f64>,
    channels: usize,
    from: usize,
    until: usize,
    /// Root of the sum of the squares of the target.
    size: f64,
    gain: Option<f64>,
    delay: bool,
}

impl Wave {
    /// Makes the distance from the target between two samples; `gain` is fixed if given, the delay is free if `delay`.
    pub fn of(target: &Target, from: usize, until: usize, gain: Option<f64>, delay: bool) -> Wave {
        let flat: Vec<f64> = target.samples.iter().flat_map(|c| c[from..until].iter().copied()).collect();
        let size = libm::sqrt(dot(&flat, &flat)).max(f64::MIN_POSITIVE);
        Wave { target: flat, channels: target.samples.len(), from, until, size, gain, delay }
    }

    /// Sum of the squares of the residuals relative to the target \[dB\].
    pub fn decibel(&self, heard: &Samples, free: Free) -> f64 {
        let r = self.residual(heard, free);
        10.0 * libm::log10(dot(&r, &r).max(1e-30))
    }

    fn moved(&self, heard: &Samples, delay: f64) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.target.len());
        for c in heard.iter().take(self.channels) {
            delayed(c, delay, self.from, self.until, &mut all);
        }
        all
    }
}

/// Appends a delayed sound between two samples.
pub(crate) fn delayed(sound: &[f64], delay: f64, from: usize, until: usize, to: &mut Vec<f64>) {
    let whole = libm::floor(delay);
    let part = delay - whole;
    let begin = from as isize - whole as isize;
    let n = until.saturating_sub(from) as isize;
    let first = to.len();
    to.resize(first + n as usize, 0.0);
    let to = &mut to[first..];
    if part == 0.0 {
        add(sound, begin, 1.0, to);
        return;
    }
    let weights: Vec<f64> = (-HALF..HALF)
        .map(|k| {
            // distance of the sample `k` later, times π
            let x = (k as f64 + part) * std::f64::consts::PI;
            let window = libm::cos(0.5 * x / HALF as f64).max(0.0);
            libm::sin(x) / x * window * window
        })
        .collect();
    for (w, k) in weights.into_iter().zip(-HALF..HALF) {
        add(sound, begin + k, w, to);
    }
}

/// Adds a weighted sound from sample `begin`; it is silent outside its samples.
fn add(sound: &[f64], begin: isize, weight: f64, to: &mut [f64]) {
    let skipped = usize::try_from(-begin).unwrap_or(0).min(to.len());
    let from = usize::try_from(begin).unwrap_or(0).min(sound.len());
    for (to, x) in to[skipped..].iter_mut().zip(&sound[from..]) {
        *to += weight * x;
    }
}

impl Loss for Wave {
    fn residual(&self, heard: &Samples, free: Free) -> Vec<f64> {
        let part = 1.0 / self.size;
        let heard = self.moved(heard, free.delay);
        heard.iter().zip(&self.target).map(|(h, t)| (free.gain * h - t) * part).collect()
    }

    fn settle(&self, heard: &Samples, free: Free) -> Free {
        if let Some(gain) = self.gain {
            return Free { gain, ..free };
        }
        let heard = self.moved(heard, free.delay);
        let own = dot(&heard, &heard);
        Free { gain: if own > 0.0 { dot(&heard, &self.target) / own } else { free.gain }, ..free }
    }

    fn free(&self) -> [bool; 2] {
        [self.gain.is_none(), self.delay]
    }

    fn stretches(&self) -> Vec<usize> {
        let n = self.until - self.from;
        (0..self.channels).flat_map(|_| (0..n).map(|i| (i * STRETCHES / n.max(1)).min(STRETCHES - 1))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_one_and_none_leaves_every_bit() {
        let sound: Vec<f64> = (0..400).map(|i| (0.31 * f64::from(i)).sin()).collect();
        let mut same = Vec::new();
        delayed(&sound, 0.0, 0, 400, &mut same);
        assert_eq!(same, sound);
        for delay in [0.25, -3.5, 7.75] {
            let mut later = Vec::new();
            delayed(&sound, delay, 100, 300, &mut later);
            let off = (0..200).map(|i| (later[i] - (0.31 * (100.0 + i as f64 - delay)).sin()).abs());
            assert!(off.fold(0.0, f64::max) < 2e-3, "{delay}");
        }
    }
}
