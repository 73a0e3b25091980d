//! The choice of a sound output.

use serde::Serialize;

/// Outputs to choose from, the present one, and the requested one.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outputs {
    /// Names that can be requested; empty if nothing can be chosen.
    pub choices: Vec<String>,
    /// Name of the output that should play.
    pub wanted: String,
    /// Description of what plays.
    pub plays: String,
    /// True while the requested output is being opened.
    pub busy: bool,
    /// Reason why the output requested last does not play.
    pub refused: Option<String>,
    /// Request that is not handled yet.
    #[serde(skip)]
    pub pending: Option<String>,
}

/// The error if outputs cannot be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoChoice;

impl std::fmt::Display for NoChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the sound output of this performance cannot be changed")
    }
}

impl std::error::Error for NoChoice {}

/// Converts to the text of a reply.
impl From<NoChoice> for String {
    fn from(why: NoChoice) -> String {
        why.to_string()
    }
}

impl Outputs {
    /// Requests another output.
    ///
    /// # Errors
    /// If nothing can be chosen.
    pub fn request(&mut self, name: &str) -> Result<(), NoChoice> {
        if self.choices.is_empty() {
            return Err(NoChoice);
        }
        (self.pending, self.busy, self.refused) = (Some(name.into()), true, None);
        Ok(())
    }
}
