//! The result of a performance.

use ca_haptic::serve::Summary;
use ca_haptic::take;
use ca_io::sound::Written;
use std::path::PathBuf;

/// Counts of frames over the lines of all devices, by name.
pub type Traffic = [(&'static str, u64); 8];

/// The result of a performance.
pub struct Report {
    /// name of the model
    pub name: String,
    /// sound rate \[Hz\]
    pub rate: f64,
    /// times, losses and faults
    pub summary: Summary,
    /// frames of devices, if the model has devices
    pub traffic: Option<Traffic>,
    /// the sound file, if it was written
    pub sound: Option<(PathBuf, Written)>,
    /// the take, if it was written
    pub take: Option<(PathBuf, take::Finished)>,
}
