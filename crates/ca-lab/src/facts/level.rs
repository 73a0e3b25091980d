//! Describes the level of a sound.

use crate::play::gain;
use ca_model::quantity::short;

/// Peak above which a lower gain is not the remedy, 40 dB over full scale.
pub const FAR: f64 = 100.0;

/// Peak that no gain makes audible, 200 dB below full scale.
pub const SILENT: f64 = 1e-10;

/// Suggests the gain at which the loudest sample fits, as the end of a sentence.
pub fn fitting(peak: f64) -> String {
    format!("; multiply the gain of the outputs by {} or less", short(gain(peak)))
}

/// Describes the number of samples that were cut off.
pub fn too_loud(n: u64) -> String {
    let samples = if n == 1 { "1 sample".into() } else { format!("{n} samples") };
    format!("{samples} beyond full scale, cut off")
}

/// Converts an amplitude to decibels of full scale.
pub fn decibel(peak: f64) -> f64 {
    20.0 * peak.log10()
}

/// Describes a peak by its level, unless no sound card or file could hold it.
pub fn level(peak: f64, diverged: bool) -> String {
    match peak {
        p if p < SILENT => "silent".into(),
        p if p > FAR && diverged => "diverged".into(),
        p if p > 1.0 / SILENT => "over 200 dBFS".into(),
        p => format!("{} dBFS", tenths(decibel(p))),
    }
}

/// Formats a number with one decimal, avoiding -0.
pub fn tenths(v: f64) -> String {
    format!("{:.1}", (v * 10.0).round() / 10.0 + 0.0)
}
