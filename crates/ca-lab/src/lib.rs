//! Finds, plays and judges any model: the work that all front ends share.
//!
//! They agree on which word means which model, how long it plays and when it has diverged.
//!
//! [`load`] finds a model, and [`play`] plays it. `ca-fit`, `ca-sweep`, `ca-accuracy`, `ca-take`, `ca-film`, `ca-pages`
//! and `ca-live` build on them. Derivatives are in `ca-gradient`. To play scenes, a program needs only `cordis-anima`.
#![forbid(unsafe_code)]

pub mod bytes;
pub mod facts;
pub mod load;
pub mod outcome;
pub mod play;
pub mod watch;

pub use cordis_anima::{Found, Loaded, catalog};

/// Reason why a request failed.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// The request is invalid.
    Usage(String),
    /// The request could not be carried out.
    Failed(String),
    /// The model has errors.
    Found(Box<Found>),
    /// The caller stopped it.
    Stopped,
}

impl Failure {
    /// Returns the message in one line; for a model, its first error.
    pub fn line(self) -> String {
        match self {
            Failure::Usage(what) | Failure::Failed(what) => what,
            Failure::Stopped => String::new(),
            Failure::Found(found) => {
                let first = found.diags.list.into_iter().find(|d| d.severity == ca_model::diag::Severity::Error);
                first.map_or_else(String::new, |d| format!("{}: {}", d.code, d.title))
            }
        }
    }
}

impl From<Box<Found>> for Failure {
    fn from(found: Box<Found>) -> Failure {
        Failure::Found(found)
    }
}

impl From<ca_io::FileError> for Failure {
    fn from(e: ca_io::FileError) -> Failure {
        match e.kind {
            ca_io::FileErrorKind::Usage | ca_io::FileErrorKind::Unsupported => Failure::Usage(e.to_string()),
            _ => Failure::Failed(e.to_string()),
        }
    }
}
