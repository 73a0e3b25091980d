//! Why an operation is refused.

use crate::{NotOne, Unreadable};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Reason why an operation does not change the text, with a remedy.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refusal {
    /// The problem, in one line.
    pub what: String,
    /// The remedy.
    pub help: String,
    /// Names of everything that refers to what should be deleted; otherwise empty.
    pub dependents: Vec<String>,
}

impl Refusal {
    pub(crate) fn new(what: impl Into<String>, help: impl Into<String>) -> Refusal {
        Refusal { what: what.into(), help: help.into(), dependents: Vec::new() }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.what, self.help)
    }
}

impl core::error::Error for Refusal {}

impl From<Unreadable> for Refusal {
    fn from(e: Unreadable) -> Refusal {
        Refusal::new(e.to_string(), "correct the text there first")
    }
}

impl From<NotOne> for Refusal {
    fn from(e: NotOne) -> Refusal {
        Refusal::new(e.to_string(), "change it in the text")
    }
}
