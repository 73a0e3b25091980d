//! Errors of this crate.
//!
//! A parameter or module without a true derivative is refused by name, because a plausible wrong number would be
//! believed.

use ca_io::FileError;
use ca_model::diag::{Diags, Severity};
use ca_model::render;
use cordis_anima::Found;
use std::fmt;

/// Reason for a missing derivative.
#[derive(Debug)]
pub enum Error {
    /// The request names something that does not exist or cannot be differentiated.
    Refused(String),
    /// The model has errors.
    Model(Box<Found>),
    /// The gesture does not fit the model.
    Gesture(FileError),
    /// The caller's [`GoesOn`](crate::GoesOn) callback returned false.
    Stopped,
}

impl Error {
    pub(crate) fn refused(what: impl Into<String>) -> Error {
        Error::Refused(what.into())
    }

    pub(crate) fn first(found: &Diags) -> String {
        found.list.iter().find(|d| d.severity == Severity::Error).map(|d| d.title.clone()).unwrap_or_default()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Refused(what) => f.write_str(what),
            Error::Model(found) => f.write_str(&render::text(&found.diags, &found.model, false)),
            Error::Gesture(e) => e.fmt(f),
            Error::Stopped => f.write_str("stopped"),
        }
    }
}

impl std::error::Error for Error {}

impl From<Box<Found>> for Error {
    fn from(found: Box<Found>) -> Error {
        Error::Model(found)
    }
}

impl From<FileError> for Error {
    fn from(e: FileError) -> Error {
        Error::Gesture(e)
    }
}
