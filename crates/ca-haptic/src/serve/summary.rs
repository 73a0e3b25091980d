//! What is reported of a performance: once a second, and at its end.

use super::audio::AudioSummary;
use crate::frame::Cause;
use crate::stats::Percentiles;
use serde::Serialize;

/// Once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StatsSnapshot {
    /// sound sample
    pub tick: u64,
    /// gesture frames so far
    pub frames: u64,
    /// computing time of a gesture frame in the last second \[µs\]
    pub frame_us: Percentiles,
    /// how late they began in the last second \[µs\]
    pub late_us: Percentiles,
    /// loop latency in the last second, all devices \[µs\]
    pub loop_us: Percentiles,
    /// periods left out so far
    pub missed: u64,
    /// device frames dropped by the input checks so far
    pub dropped: u64,
    /// gesture frames without news of a device that was there, so far
    pub stale: u64,
    /// faults that latched so far
    pub faults: u64,
    /// sound samples at the peak limit so far
    pub clipped: u64,
    /// records, sounds and forces lost so far
    pub lost: u64,
    /// part of the time the engine computes, 1 = all of it
    pub load: f64,
    /// times there was nothing to play, or the device that plays said so, so far; 0 without one
    pub underruns: u64,
    /// its rate against the monotonic clock \[ppm\]; 0 without one
    pub ppm: f64,
}

/// A fault that latched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// which device
    pub device: String,
    /// why
    pub cause: Cause,
    /// sound sample
    pub tick: u64,
}

/// One device at the end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviceSummary {
    /// its name
    pub device: String,
    /// its profile
    pub profile: String,
    /// frames that came
    pub frames: u64,
    /// of these, dropped by the input checks
    pub dropped: u64,
    /// keys that were softened to what the device holds, as the model was at the end: name, and what was felt \[N/m\]
    pub softened: Vec<(String, f64)>,
    /// loop latency \[µs\]
    pub loop_us: Percentiles,
    /// whether forces began at any time
    pub forces_on: bool,
    /// armed and off to the end: what it waited for
    pub waits: Option<String>,
}

/// All of a performance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// how long it sounded \[s\]
    pub seconds: f64,
    /// gesture frames
    pub frames: u64,
    /// a gesture frame \[µs\]
    pub period_us: f64,
    /// computing time of a gesture frame \[µs\]
    pub frame_us: Percentiles,
    /// how late gesture frames began \[µs\]
    pub late_us: Percentiles,
    /// periods left out because the one before was not done
    pub missed: u64,
    /// gesture frames without news from a device that had been there
    pub stale: u64,
    /// device frames dropped by the input checks
    pub dropped: u64,
    /// force frames nobody fetched
    pub lost_forces: u64,
    /// records that found no room in the rings or on their way to a file
    pub lost_records: u64,
    /// sound samples that found none, of all files together
    pub lost_sound: u64,
    /// pictures that found none
    pub lost_views: u64,
    /// frames whose times are in none of the figures above: nobody fetched them in time
    pub lost_timings: u64,
    /// sound samples cut at full scale
    pub clipped: u64,
    /// changes that did not fit
    pub refused: u64,
    /// the model diverged, and was not loaded again
    pub unstable: bool,
    /// devices
    pub devices: Vec<DeviceSummary>,
    /// faults, in order
    pub faults: Vec<Fault>,
    /// files that could not be written to their end, and why
    pub broken: Vec<String>,
    /// what the system granted each thread, as it says itself
    pub granted: Vec<(String, String)>,
    /// the device that played the sound, if one did
    pub audio: Option<AudioSummary>,
    /// those that played before it, in order
    pub audio_before: Vec<AudioSummary>,
}

impl Summary {
    /// True where nothing was lost, cut, left unwritten or diverged. Faults of a hand or device are no loss.
    pub fn is_faithful(&self) -> bool {
        let lost = self.lost_forces + self.lost_records + self.lost_sound + self.lost_views + self.lost_timings;
        let heard = self.audio.iter().chain(&self.audio_before).all(AudioSummary::is_faithful);
        lost == 0 && self.broken.is_empty() && self.clipped == 0 && !self.unstable && self.refused == 0 && heard
    }
}
