//! Statistics of a performance: once a second, and at its end.

use super::audio::AudioSummary;
use crate::frame::Cause;
use crate::stats::Percentiles;
use serde::Serialize;

/// Statistics, once a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct StatsSnapshot {
    /// Sound sample.
    pub tick: u64,
    /// Gesture frames so far.
    pub frames: u64,
    /// Computing time of a gesture frame in the last second \[µs\].
    pub frame_us: Percentiles,
    /// Delay of the start of gesture frames in the last second \[µs\].
    pub late_us: Percentiles,
    /// Loop latency in the last second, all devices \[µs\].
    pub loop_us: Percentiles,
    /// Periods left out so far.
    pub missed: u64,
    /// Device frames dropped by the input checks so far.
    pub dropped: u64,
    /// Gesture frames without a new frame from a connected device, so far.
    pub stale: u64,
    /// Faults that latched so far.
    pub faults: u64,
    /// Sound samples at the peak limit so far.
    pub clipped: u64,
    /// Records, sound samples, pictures, forces and timings lost so far.
    pub lost: u64,
    /// Fraction of the time in which the engine computes.
    pub load: f64,
    /// Underruns so far, including those that the sound device reports; 0 without a device.
    pub underruns: u64,
    /// Deviation of its rate from nominal, by the monotonic clock \[ppm\]; 0 without a device.
    pub ppm: f64,
}

/// A fault that latched.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// Name of the device.
    pub device: String,
    /// Cause.
    pub cause: Cause,
    /// Sound sample.
    pub tick: u64,
}

/// Summary of one device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviceSummary {
    /// Name.
    pub device: String,
    /// Name of its profile.
    pub profile: String,
    /// Frames received.
    pub frames: u64,
    /// Received frames that the input checks dropped.
    pub dropped: u64,
    /// Keys softened to the limit of the device, in the last model version: name, and stiffness at the hand \[N/m\].
    pub softened: Vec<(String, f64)>,
    /// Loop latency \[µs\].
    pub loop_us: Percentiles,
    /// True if forces were on at any time.
    pub forces_on: bool,
    /// Reason for which it waited, if it was armed without force to the end.
    pub waits: Option<String>,
}

/// Summary of a performance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Duration \[s\].
    pub seconds: f64,
    /// Gesture frames.
    pub frames: u64,
    /// Period of a gesture frame \[µs\].
    pub period_us: f64,
    /// Computing time of a gesture frame \[µs\].
    pub frame_us: Percentiles,
    /// Delay of the start of gesture frames \[µs\].
    pub late_us: Percentiles,
    /// Periods left out.
    pub missed: u64,
    /// Gesture frames without a new frame from a connected device.
    pub stale: u64,
    /// Device frames dropped by the input checks.
    pub dropped: u64,
    /// Force frames that were not read in time.
    pub lost_forces: u64,
    /// Records lost in full rings or on the way to a file.
    pub lost_records: u64,
    /// Sound samples lost in the same way, of all files together.
    pub lost_sound: u64,
    /// Pictures lost in the same way.
    pub lost_views: u64,
    /// Frames missing in the times above, because their timings were lost.
    pub lost_timings: u64,
    /// Sound samples cut at full scale.
    pub clipped: u64,
    /// Commands that did not fit the scene.
    pub refused: u64,
    /// True if the model diverged and was not loaded again.
    pub unstable: bool,
    /// Devices.
    pub devices: Vec<DeviceSummary>,
    /// Faults, in order.
    pub faults: Vec<Fault>,
    /// Errors of the files that could not be written to their end.
    pub broken: Vec<String>,
    /// Rights that the system granted each thread, as the system reports them.
    pub granted: Vec<(String, String)>,
    /// Sound device, if there was one.
    pub audio: Option<AudioSummary>,
    /// Earlier sound devices, in order.
    pub audio_before: Vec<AudioSummary>,
}

impl Summary {
    /// Returns true if nothing was lost, cut or left unwritten, and nothing diverged. Faults of devices do not count.
    pub fn is_faithful(&self) -> bool {
        let lost = self.lost_forces + self.lost_records + self.lost_sound + self.lost_views + self.lost_timings;
        let heard = self.audio.iter().chain(&self.audio_before).all(AudioSummary::is_faithful);
        lost == 0 && self.broken.is_empty() && self.clipped == 0 && !self.unstable && self.refused == 0 && heard
    }
}
