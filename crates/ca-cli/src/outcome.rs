//! Outcome of a command, and conversion of the failures of other crates.
//!
//! Commands return their outcome and never exit, so that all values are dropped. Only `crate::run` maps outcomes to
//! exit codes.

use crate::term;
use ca_device_tools::ToolError;
use ca_haptic::host::{HostError, HostErrorKind};

/// Outcome of a command without a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Finished as requested.
    Well,
    /// Finished, but not as intended: unstable, clipped, or with refused inputs.
    Degraded,
}

/// Reason for a failure. Its message is printed on stderr.
#[derive(Debug)]
pub enum Failure {
    /// Invalid request: exit code 2.
    Usage(String),
    /// Failed request: exit code 1.
    Failed(String),
    /// Failed request whose message is already printed: exit code 1.
    Reported,
    /// Ctrl-C: exit code 130, with a message about the work that is kept.
    Interrupted(String),
    /// The reader of standard output, or of another pipe, closed it.
    BrokenPipe,
}

impl From<std::io::Error> for Failure {
    fn from(e: std::io::Error) -> Failure {
        match e.kind() {
            std::io::ErrorKind::BrokenPipe => Failure::BrokenPipe,
            _ => Failure::Failed(format!("cannot write to standard output: {e}")),
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

/// Result of every command.
pub type Outcome = Result<Ended, Failure>;
