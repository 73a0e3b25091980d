//! What is said about shared memory that cannot be used.
//!
//! Decides, as for files, on one record: a kind for programs; for people what is wrong and one thing to do about it.
//! The twenty variants of each iceoryx2 call end here.

use std::fmt;

/// What sort of failure, for programs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum HostErrorKind {
    /// the place of the shared memory cannot be used: too long, not ours, not writable
    Site,
    /// a device cannot have this name
    Name,
    /// somebody else has this place: end that process, or take another name
    Busy,
    /// the other side speaks another version or layout: build both from one release
    Version,
    /// nobody answers: start the other side and try again
    Absent,
    /// an answer that makes no sense
    Answer,
    /// the system refused something; what, is in the text
    System,
}

/// Why shared memory could not be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostError {
    /// what sort of failure
    pub kind: HostErrorKind,
    /// what is wrong
    pub what: String,
    /// what to do about it; empty where nothing sensible can be said
    pub fix: String,
}

impl HostError {
    pub(crate) fn new(kind: HostErrorKind, what: impl Into<String>, fix: impl Into<String>) -> HostError {
        HostError { kind, what: what.into(), fix: fix.into() }
    }
    /// Something the system or iceoryx2 refused.
    pub(crate) fn system(what: impl fmt::Display, why: impl fmt::Debug) -> HostError {
        HostError::new(
            HostErrorKind::System,
            format!("{what}: {why:?}"),
            "see `ca shm list`; `ca shm clean` removes what ended processes have left",
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
