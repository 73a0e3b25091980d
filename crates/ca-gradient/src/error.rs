//! Error: why there is no derivative.
//!
//! Decides that whatever has no true derivative is refused, with the name of the parameter or module: a number that looks like
//! one would be believed.

use ca_io::FileError;
use ca_model::diag::{Diags, Severity};
use ca_model::render;
use cordis_anima::Found;
use std::fmt;

/// Why there is no derivative.
#[derive(Debug)]
pub enum Error {
    /// what was asked for is not there, or has no derivative
    Refused(String),
    /// the model has errors
    Model(Box<Found>),
    /// the gesture does not fit the model
    Gesture(FileError),
    /// who was asked did not want more of it
    Stopped,
}

impl Error {
    pub(crate) fn refused(what: impl Into<String>) -> Error {
        Error::Refused(what.into())
    }

    /// The first error among findings.
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
