//! The outputs among which a person chooses.

use serde::Serialize;

/// Outputs to choose from, the present one, and the one that is asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outputs {
    /// names that can be asked for; none where nothing can be chosen
    pub choices: Vec<String>,
    /// the name that is to play
    pub wanted: String,
    /// what plays, in words
    pub plays: String,
    /// what was asked for last is being opened
    pub busy: bool,
    /// why what was asked for last does not play
    pub refused: Option<String>,
    /// asked for, and not looked at yet
    #[serde(skip)]
    pub asked: Option<String>,
}

/// Outputs cannot be chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoChoice;

impl std::fmt::Display for NoChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the sound goes to no device that could be chosen")
    }
}

impl std::error::Error for NoChoice {}

/// An answer to a request is a text.
impl From<NoChoice> for String {
    fn from(why: NoChoice) -> String {
        why.to_string()
    }
}

impl Outputs {
    /// Asks for another.
    ///
    /// # Errors
    /// If nothing can be chosen.
    pub fn ask(&mut self, name: &str) -> Result<(), NoChoice> {
        if self.choices.is_empty() {
            return Err(NoChoice);
        }
        (self.asked, self.busy, self.refused) = (Some(name.into()), true, None);
        Ok(())
    }
}
