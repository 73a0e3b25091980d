//! Errors of loading and playing a model.

use ca_io::FileError;
use ca_model::Model;
use ca_model::diag::Diags;
use ca_model::render;

/// Findings, with the model whose text they point into.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Model with its text.
    pub model: Model,
    /// All findings, with at least one error.
    pub diags: Diags,
}

/// Error of loading or playing a model. As text, it shows each finding below the line that it points to.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Error {
    /// File that cannot be read, or gesture that does not fit the scene.
    File(FileError),
    /// Model with errors.
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
