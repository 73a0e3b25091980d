//! Partials of a recording: their frequencies and decays.
//!
//! They are peaks of a padded spectrum, with lines through their levels over time. A subspace method is not needed: the
//! result only has to be so near that phases do not slip, and peaks show by themselves what exceeds the noise.

use crate::target::{Samples, mixed};
use ca_report::Hann;
use ca_report::pitch::{apex, fall};

/// Longest window \[s\].
const WINDOW: f64 = 0.7;
/// Length with zeros, as a multiple of the window.
const PADDED: usize = 4;
/// Partials further below the strongest are ignored \[dB\].
const DEPTH: f64 = 60.0;
/// Least height of a peak above its surroundings \[dB\].
const ABOVE: f64 = 12.0;
/// Maximum number of partials.
const MOST: usize = 40;
/// Lowest frequency \[Hz\].
const LOWEST: f64 = 25.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Partial {
    /// Frequency \[Hz\].
    pub f: f64,
    /// Level relative to the strongest \[dB\], at most 0.
    pub level: f64,
    /// Decay time \[s\]; `None` where it does not fall.
    pub t60: Option<f64>,
}

/// Returns the partials of a sound, strongest first.
pub(crate) fn partials(sound: &Samples, from: usize, rate: f64) -> Vec<Partial> {
    let one = mixed(sound);
    let sound = one.first().and_then(|c| c.get(from..)).unwrap_or(&[]);
    let longest = (sound.len() / 2).min((WINDOW * rate) as usize).max(64);
    let length = (longest + 1).next_power_of_two() / 2;
    let mut windows = Hann::new(length, PADDED * length);
    let (hop, last) = (length / 4, sound.len().saturating_sub(length));
    let frames: Vec<Vec<f64>> = (0..=last / hop.max(1))
        .map(|i| {
            let mut powers = Vec::new();
            windows.powers(sound, i * hop, &mut powers);
            powers
        })
        .collect();
    let n = windows.size() / 2 + 1;
    let mean: Vec<f64> = (0..n).map(|k| frames.iter().map(|f| f[k]).sum::<f64>() / frames.len() as f64).collect();
    let step = rate / windows.size() as f64;
    let top = mean.iter().skip((LOWEST / step) as usize).copied().fold(0.0, f64::max);
    // the main lobe of a window is four bins wide before padding
    let lobe = 2 * PADDED;
    let around = 6 * lobe;
    let mut found: Vec<Partial> = Vec::new();
    let first = ((LOWEST / step) as usize).max(lobe);
    for k in first..n.saturating_sub(lobe) {
        let here = mean[k];
        let highest = (k - lobe..=k + lobe).all(|i| mean[i] <= here);
        if !highest || here <= top * 10f64.powf(-DEPTH / 10.0) {
            continue;
        }
        let mut near: Vec<f64> = mean[k.saturating_sub(around)..(k + around).min(n)].to_vec();
        near.sort_by(f64::total_cmp);
        if here < near[near.len() / 4] * 10f64.powf(ABOVE / 10.0) {
            continue;
        }
        let levels: Vec<f64> = frames.iter().map(|f| f[k - 2..=k + 2].iter().sum::<f64>()).collect();
        found.push(Partial {
            f: apex(&mean, k) * step,
            level: 10.0 * libm::log10(here / top),
            t60: t60(&levels, hop as f64 / rate),
        });
    }
    found.sort_by(|a, b| b.level.total_cmp(&a.level));
    found.truncate(MOST);
    found
}

/// Fits a line through the levels from the loudest down to 40 dB below it.
fn t60(powers: &[f64], step: f64) -> Option<f64> {
    let levels: Vec<f64> = powers.iter().map(|p| 10.0 * libm::log10(p.max(f64::MIN_POSITIVE))).collect();
    let (slope, points) = fall(&levels, 40.0)?;
    let slope = slope / step;
    (points >= 3 && slope < -0.1).then_some(-60.0 / slope)
}
