//! Why a model could not be loaded or played.
//!
//! Decides on two cases: a file that could not be read, and a model with errors, which keeps the model so that the
//! findings can be shown in its text.

use ca_io::FileError;
use ca_model::Model;
use ca_model::diag::Diags;
use ca_model::render;

/// Findings, with the model they point into.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// the model
    pub model: Model,
    /// errors, and what else was found
    pub diags: Diags,
}

/// Why a model could not be loaded or played. As text, the findings stand below the lines they are about.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// a file cannot be read, or a gesture does not fit
    File(FileError),
    /// the model has errors
    Model(Box<Found>),
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Error::File(e) => e.fmt(f),
            Error::Model(found) => f.write_str(&render::text(&found.diags, &found.model, false)),
        }
    }
}

impl std::error::Error for Error {}

impl From<FileError> for Error {
    fn from(e: FileError) -> Error {
        Error::File(e)
    }
}

impl From<Box<Found>> for Error {
    fn from(found: Box<Found>) -> Error {
        Error::Model(found)
    }
}
