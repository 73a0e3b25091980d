//! The error of shared memory: a kind for programs, and for people a message with one remedy, as for files. It replaces
//! the twenty error variants of each iceoryx2 call.

use std::fmt;

/// Kind of an error, for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HostErrorKind {
    /// The folder of the site cannot be used: path too long, owned by another user, or not writable.
    Site,
    /// The name of a device is invalid.
    Name,
    /// Another process has the device or site: end that process, or choose another name.
    Busy,
    /// The other side uses another version or layout: build both from one release.
    Version,
    /// The other side does not answer: start it and try again.
    Absent,
    /// The answer cannot be parsed.
    Answer,
    /// A call to the system or to iceoryx2 failed; the text names it.
    System,
}

/// An error of shared memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostError {
    /// Kind, for programs.
    pub kind: HostErrorKind,
    /// Message for people.
    pub what: String,
    /// Remedy; empty if none is known.
    pub fix: String,
}

impl HostError {
    pub(crate) fn new(kind: HostErrorKind, what: impl Into<String>, fix: impl Into<String>) -> HostError {
        HostError { kind, what: what.into(), fix: fix.into() }
    }
    pub(crate) fn system(what: impl fmt::Display, why: impl fmt::Debug) -> HostError {
        HostError::new(
            HostErrorKind::System,
            format!("{what}: {why:?}"),
            "see `ca shm list`; `ca shm clean` removes the files of ended processes",
        )
    }
}

impl fmt::Display for HostError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.what)?;
        if self.fix.is_empty() { Ok(()) } else { write!(f, "; {}", self.fix) }
    }
}

impl std::error::Error for HostError {}
