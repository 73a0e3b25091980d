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

impl Outputs {
    /// Asks for another.
    ///
    /// # Errors
    /// In words, where nothing can be chosen.
    pub fn ask(&mut self, name: &str) -> Result<(), String> {
        if self.choices.is_empty() {
            return Err("the sound goes to no device that could be chosen".into());
        }
        (self.asked, self.busy, self.refused) = (Some(name.into()), true, None);
        Ok(())
    }
}
