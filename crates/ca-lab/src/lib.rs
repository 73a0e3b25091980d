//! The work that every program does with a model: find it, play it, judge the sound.
//!
//! The front ends share more than the engine: which word means which model, how long it is played, and when it has diverged. A front end
//! adds its arguments and its output.
//!
//! Begin with [`load`], which finds a model, and [`play`]; `ca-fit`, `ca-sweep`, `ca-accuracy`, `ca-take`, `ca-film`, `ca-pages` and `ca-live` stand on
//! them. Derivatives are in `ca-gradient`. A program that plays scenes needs `cordis-anima` alone.
#![forbid(unsafe_code)]

pub mod bytes;
pub mod facts;
pub mod load;
pub mod outcome;
pub mod play;
pub mod watch;

pub use cordis_anima::{Found, Loaded, catalog};

/// Why something could not be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// the request makes no sense
    Usage(String),
    /// the request could not be done
    Failed(String),
    /// the model has errors
    Found(Box<Found>),
    /// whoever asked wants no more of it
    Stopped,
}

impl Failure {
    /// In a line: of a model, its first error.
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
