//! Result of a performance.

use ca_haptic::serve::Summary;
use ca_haptic::take;
use ca_io::sound::Written;
use std::path::PathBuf;

/// Frame counts over the connections of all devices, by name.
pub type Traffic = [(&'static str, u64); 8];

/// Result of a performance.
pub struct Report {
    /// Name of the model.
    pub name: String,
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Times, losses and faults.
    pub summary: Summary,
    /// Frames of devices, if the model has devices.
    pub traffic: Option<Traffic>,
    /// Sound file, if one was written.
    pub sound: Option<(PathBuf, Written)>,
    /// Take, if one was written.
    pub take: Option<(PathBuf, take::Finished)>,
}
