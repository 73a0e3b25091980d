//! Tools for device processes, used by `ca device`: conformance tests, calibration, a simulated device, and checks of
//! this machine.
//!
//! Nothing here prints, asks a person or ends the process: a tool returns data, and passes [`Message`]s about its work
//! to the caller.
//!
//! The entry points are [`conformance::run`], [`doctor::examine`], [`calibrate::Reader`] and [`simulator::Simulator`].
//! [`store`] finds the profiles and calibrations of a user.
#![forbid(unsafe_code)]

pub mod calibrate;
pub mod conformance;
pub mod doctor;
pub mod simulator;
pub mod store;

use ca_haptic::frame::{About, DOF};
use ca_haptic::host::HostError;
use ca_haptic::profile::Profile;
use ca_io::FileError;
use std::fmt;

/// A message about the work of a tool, for people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// Information.
    Note(String),
    /// Something is not as it should be.
    Warning(String),
}

/// Reason why a tool failed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ToolError {
    /// The request makes no sense.
    Usage(String),
    /// The request could not be carried out.
    Failed(String),
    /// Shared memory could not be used.
    Host(HostError),
    /// A file could not be read or written.
    File(FileError),
}

impl From<HostError> for ToolError {
    fn from(e: HostError) -> ToolError {
        ToolError::Host(e)
    }
}

impl From<FileError> for ToolError {
    fn from(e: FileError) -> ToolError {
        ToolError::File(e)
    }
}

impl fmt::Display for ToolError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ToolError::Usage(what) | ToolError::Failed(what) => f.write_str(what),
            ToolError::Host(e) => e.fmt(f),
            ToolError::File(e) => e.fmt(f),
        }
    }
}

impl std::error::Error for ToolError {}

/// Makes the record in which a device of this profile describes itself.
pub fn about(name: &str, p: &Profile) -> About {
    let mut about = About { axes: p.axes as u16, ..About::new(name, p.rate.round() as u32, p.dof as usize) };
    for k in 0..(p.dof as usize).min(DOF) {
        (about.low[k], about.high[k]) = (p.range[0] as f32, p.range[1] as f32);
        (about.force[k], about.continuous[k]) = (p.force as f32, p.continuous() as f32);
        (about.stiffness[k], about.damping[k]) = (p.stiffness.unwrap_or(0.0) as f32, p.damping.unwrap_or(0.0) as f32);
    }
    write(&mut about.model, &p.title);
    write(&mut about.firmware, concat!("ca ", env!("CARGO_PKG_VERSION")));
    about
}

/// Writes a text into a zeroed field of fixed length, cut between characters.
fn write(to: &mut [u8], text: &str) {
    let end = text.char_indices().map(|(at, c)| at + c.len_utf8()).take_while(|e| *e <= to.len()).last();
    let end = end.unwrap_or(0);
    to[..end].copy_from_slice(&text.as_bytes()[..end]);
}
