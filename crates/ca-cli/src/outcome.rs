//! How a command ended, and what of the failures of the crates below is a wrong request.
//!
//! Decides that commands give back how they ended and never exit themselves, so that what is left over is dropped; which exit
//! code that is stands in one place, `main`.

use crate::term;
use ca_device_tools::ToolError;
use ca_haptic::host::{HostError, HostErrorKind};

/// How a command ended where it did not fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// as asked
    Well,
    /// something was made, but not what was meant: unstable, clipped, inputs refused
    Degraded,
}

/// Why a command failed. What is said ends up on stderr.
#[derive(Debug)]
pub enum Failure {
    /// the request makes no sense: exit code 2
    Usage(String),
    /// the request could not be done: exit code 1
    Failed(String),
    /// as before, but all is already said: exit code 1
    Reported,
    /// Ctrl-C: exit code 130; with a message about the work that is kept
    Interrupted(String),
    /// the reader of standard output, or of another pipe, went away
    BrokenPipe,
}

impl From<std::io::Error> for Failure {
    fn from(e: std::io::Error) -> Failure {
        match e.kind() {
            std::io::ErrorKind::BrokenPipe => Failure::BrokenPipe,
            _ => Failure::Failed(format!("stdout cannot be written: {e}")),
        }
    }
}

impl From<ca_io::FileError> for Failure {
    fn from(e: ca_io::FileError) -> Failure {
        match e.kind {
            ca_io::FileErrorKind::Usage | ca_io::FileErrorKind::Unsupported => Failure::Usage(e.to_string()),
            ca_io::FileErrorKind::Left => Failure::BrokenPipe,
            _ => Failure::Failed(e.to_string()),
        }
    }
}

impl From<ca_lab::Failure> for Failure {
    fn from(e: ca_lab::Failure) -> Failure {
        match e {
            ca_lab::Failure::Usage(what) => Failure::Usage(what),
            ca_lab::Failure::Failed(what) => Failure::Failed(what),
            ca_lab::Failure::Stopped => Failure::Interrupted("interrupted: nothing was written".into()),
            ca_lab::Failure::Found(found) => {
                term::findings(&found.diags, &found.model);
                Failure::Reported
            }
        }
    }
}

impl From<HostError> for Failure {
    fn from(e: HostError) -> Failure {
        match e.kind {
            HostErrorKind::Site | HostErrorKind::Name => Failure::Usage(e.to_string()),
            _ => Failure::Failed(e.to_string()),
        }
    }
}

impl From<ToolError> for Failure {
    fn from(e: ToolError) -> Failure {
        match e {
            ToolError::Usage(what) => Failure::Usage(what),
            ToolError::Failed(what) => Failure::Failed(what),
            ToolError::Host(e) => e.into(),
            ToolError::File(e) => e.into(),
        }
    }
}

/// What every command gives back.
pub type Outcome = Result<Ended, Failure>;
