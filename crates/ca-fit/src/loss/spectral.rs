//! Distance of two sounds by levels in bands, in windows of three lengths.
//!
//! It compares logarithms of powers in bands of a twenty-fourth of an octave, or of one bin where that is wider. So it
//! is smooth where phases do not agree, a faint partial counts as much as a loud one, as in hearing, and high bands do
//! not dominate by their number. Long windows determine frequencies, short ones the onset. Levels 60 dB below the
//! loudest of their window length, or near the noise before the onset, are not distinguished.

use super::{Free, Loss, STRETCHES};
use crate::target::{Samples, Target};
use ca_report::Hann;
use std::cell::RefCell;

/// Lengths of windows \[s\].
const WINDOWS: [f64; 3] = [0.02, 0.08, 0.32];
/// Frequency ratio of a band.
const BAND: f64 = 1.029_302_236_643_492;
/// Lowest band \[Hz\].
const LOWEST: f64 = 30.0;
/// Power, relative to the loudest, below which levels are not distinguished.
const FLOOR: f64 = 1e-6;
/// Power, relative to the noise, below which levels are not distinguished.
const NOISE: f64 = 4.0;

struct Scale {
    windows: RefCell<Hann>,
    /// First sample of each window.
    begins: Vec<usize>,
    /// First bin of each band, and the end of the last.
    bands: Vec<usize>,
    /// Power of each band below which levels are not distinguished.
    floor: Vec<f64>,
    /// Powers of the target: channels, windows, bands.
    target: Vec<f64>,
}

pub(crate) struct Spectral {
    scales: Vec<Scale>,
    from: usize,
    fitted: usize,
    gain: Option<f64>,
}

impl Scale {
    fn powers(&self, sound: &Samples) -> Vec<f64> {
        let (mut all, mut powers) = (Vec::new(), Vec::new());
        let mut windows = self.windows.borrow_mut();
        for channel in sound {
            for begin in &self.begins {
                windows.powers(channel, *begin, &mut powers);
                let bands = self.bands.windows(2).map(|b| powers[b[0]..b[1]].iter().sum::<f64>());
                all.extend(bands);
            }
        }
        all
    }

    /// Noise of each band: the median over windows and channels before the onset; 0 where there are too few.
    fn noise(&self, quiet: &Samples) -> Vec<f64> {
        let (mut windows, mut powers) = (self.windows.borrow_mut(), Vec::new());
        let bands = self.bands.len() - 1;
        let mut all: Vec<Vec<f64>> = vec![Vec::new(); bands];
        for channel in quiet {
            let mut begin = 0;
            while begin + windows.length() <= channel.len() {
                windows.powers(channel, begin, &mut powers);
                let sums = self.bands.windows(2).map(|b| powers[b[0]..b[1]].iter().sum::<f64>());
                all.iter_mut().zip(sums).for_each(|(a, p)| a.push(p));
                begin += windows.length() / 2;
            }
        }
        let median = |mut list: Vec<f64>| {
            list.sort_by(f64::total_cmp);
            if list.len() < 3 { 0.0 } else { list[list.len() / 2] }
        };
        all.into_iter().map(median).collect()
    }

    fn floors(&self) -> impl Iterator<Item = &f64> {
        self.floor.iter().cycle()
    }
}

impl Spectral {
    /// Makes the distance from the target between two samples; `gain` is fixed if given.
    pub fn of(target: &Target, from: usize, until: usize, gain: Option<f64>) -> Spectral {
        let samples: Samples = target.samples.iter().map(|c| c[..until].to_vec()).collect();
        let scale = |seconds: f64| {
            let length = ((seconds * target.rate) as usize).next_power_of_two();
            if length < 16 || 2 * length > until - from && seconds > WINDOWS[0] {
                return None;
            }
            let windows = Hann::new(length, length);
            let step = target.rate / length as f64;
            let mut bands = vec![((LOWEST / step) as usize).max(1)];
            while let Some(last) = bands.last().copied().filter(|b| *b < length / 2) {
                bands.push(((last as f64 * BAND) as usize).max(last + 1).min(length / 2));
            }
            let begins = (from..(until - length.min(until - from)).max(from + 1)).step_by(length / 2).collect();
            let mut scale =
                Scale { windows: RefCell::new(windows), begins, bands, floor: Vec::new(), target: Vec::new() };
            scale.target = scale.powers(&samples);
            let floor = FLOOR * scale.target.iter().copied().fold(0.0, f64::max);
            scale.floor = scale.noise(&target.quiet).iter().map(|n| (NOISE * n).max(floor)).collect();
            (floor > 0.0).then_some(scale)
        };
        let scales = WINDOWS.into_iter().filter_map(scale).collect();
        Spectral { scales, from, fitted: until, gain }
    }

    /// Root mean square of the level differences \[dB\].
    pub fn decibel(&self, heard: &Samples, free: Free) -> f64 {
        let r = self.residual(heard, free);
        let sum: f64 = r.iter().map(|v| v * v).sum();
        10.0 / std::f64::consts::LN_10 * libm::sqrt(sum / self.scales.len().max(1) as f64)
    }
}

/// Shifts a sound by whole samples to its position in the target.
fn moved(heard: &Samples, delay: f64) -> Samples {
    let by = libm::round(delay) as isize;
    heard
        .iter()
        .map(|c| {
            let silent = by.max(0) as usize;
            let skipped = (-by).max(0) as usize;
            std::iter::repeat_n(0.0, silent).chain(c.iter().skip(skipped).copied()).collect()
        })
        .collect()
}

impl Loss for Spectral {
    fn residual(&self, heard: &Samples, free: Free) -> Vec<f64> {
        let heard = moved(heard, free.delay);
        let square = free.gain * free.gain;
        let mut all = Vec::new();
        for scale in &self.scales {
            let powers = scale.powers(&heard);
            // each window length has the same weight
            let w = 1.0 / libm::sqrt(powers.len() as f64);
            let one = |((p, t), floor): ((&f64, &f64), &f64)| w * libm::log((square * p + floor) / (t + floor));
            all.extend(powers.iter().zip(&scale.target).zip(scale.floors()).map(one));
        }
        all
    }

    fn settle(&self, heard: &Samples, free: Free) -> Free {
        if let Some(gain) = self.gain {
            return Free { gain, ..free };
        }
        // the mean of the distinguished levels, iterated since the gain decides which ones are distinguished
        let heard = moved(heard, free.delay);
        let powers: Vec<Vec<f64>> = self.scales.iter().map(|s| s.powers(&heard)).collect();
        let whole =
            |of: &dyn Fn(&Scale, usize) -> f64| -> f64 { self.scales.iter().enumerate().map(|(i, s)| of(s, i)).sum() };
        let (t, p) = (whole(&|s, _| s.target.iter().sum()), whole(&|_, i| powers[i].iter().sum()));
        let mut square = if p > 0.0 && free.gain == 0.0 { t / p } else { free.gain * free.gain };
        for _ in 0..12 {
            let (mut slope, mut off) = (0.0, 0.0);
            for (s, powers) in self.scales.iter().zip(&powers) {
                let w = 1.0 / powers.len() as f64;
                for ((p, t), floor) in powers.iter().zip(&s.target).zip(s.floors()) {
                    let part = square * p / (square * p + floor);
                    off += w * part * libm::log((square * p + floor) / (t + floor));
                    slope += w * part * part;
                }
            }
            let step = if slope > 0.0 { (off / slope).clamp(-2.0, 2.0) } else { 0.0 };
            square *= libm::exp(-step);
            if step.abs() < 1e-9 {
                break;
            }
        }
        Free { gain: libm::copysign(libm::sqrt(square), if free.gain < 0.0 { -1.0 } else { 1.0 }), ..free }
    }

    fn free(&self) -> [bool; 2] {
        [self.gain.is_none(), false]
    }

    fn stretches(&self) -> Vec<usize> {
        let whole = (self.fitted - self.from).max(1);
        let mut all = Vec::new();
        for scale in &self.scales {
            let per = scale.begins.len() * (scale.bands.len() - 1);
            let channels = scale.target.len() / per.max(1);
            for _ in 0..channels {
                for begin in &scale.begins {
                    let stretch = ((begin - self.from) * STRETCHES / whole).min(STRETCHES - 1);
                    all.extend(std::iter::repeat_n(stretch, scale.bands.len() - 1));
                }
            }
        }
        all
    }
}
