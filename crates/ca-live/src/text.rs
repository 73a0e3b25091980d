//! The text of a model with changed values, for other people.

use ca_edit::{Document, write_change};
use ca_lab::Failure;
use ca_lab::load::{self, Loaded, own_text};
use ca_model::write;
use std::sync::{Arc, Mutex};

/// A model and its changes.
#[derive(Clone)]
pub(crate) struct Snapshot {
    pub(crate) loaded: Arc<Loaded>,
    pub(crate) changes: Vec<(String, String)>,
}

impl Snapshot {
    /// Returns the text with the changes; `None` if the model cannot have them. It reads the model again, so it may take
    /// long.
    pub(crate) fn text(&self) -> Option<String> {
        with_changes(&self.loaded, &self.changes).ok()
    }
}

/// The snapshot that a page stored last.
pub(crate) type Stored = Arc<Mutex<Option<Snapshot>>>;

/// Returns the text of a model in which `changes` are written. The text keeps its comments where each change has one
/// place in it; otherwise it is written anew from the changed model.
///
/// # Errors
/// If the model cannot have one of the values.
fn with_changes(loaded: &Loaded, changes: &[(String, String)]) -> Result<String, Failure> {
    let mut changed = loaded.clone();
    for (name, value) in changes {
        load::set_typed(&mut changed, name, value)?;
    }
    let anew = write::write(&changed.model);
    let is_same = |text: &String| words(&write::write(&load::reread(loaded, text).model)) == words(&anew);
    Ok(edited(loaded, changes).filter(is_same).unwrap_or(anew))
}

/// Returns the words of a text in alphabetical order, because a changed value may be at another place of its table.
fn words(text: &str) -> Vec<&str> {
    let mut words: Vec<&str> = text.split([' ', ',', '\n']).filter(|w| !w.is_empty()).collect();
    words.sort_unstable();
    words
}

/// Writes changes at their places in the text; `None` if the text lacks one of the places.
fn edited(loaded: &Loaded, changes: &[(String, String)]) -> Option<String> {
    let text = own_text(loaded);
    if changes.is_empty() {
        return Some(text);
    }
    let mut text = Document::read(&text).ok()?;
    for (name, value) in changes {
        write_change(&mut text, &loaded.model, name, value).ok()?;
    }
    Some(text.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINE: &str = "# mine
[param]
k = { value = \"2 kN/m\", unit = \"N/m\", live = true, min = 200, max = 4000 } # soft
[STRING]
low = { n = 30, f = \"110 Hz\", t60 = \"3 s\", m = \"1 g\" } # the string
[MAS]
bob = { m = \"10 g\" }
[REF]
spring = { between = [\"low[3]\", \"bob\"], k = \"k\" }
[SOX]
left = { from = \"low[6]\", gain = 200 }
[preset]
hard = { k = 4000 }
";

    fn text(model: &str, changes: &[(&str, &str)]) -> String {
        let changes: Vec<_> = changes.iter().map(|(n, v)| (n.to_string(), v.to_string())).collect();
        with_changes(&Loaded::read(model, "mine.ca.toml"), &changes).unwrap()
    }

    #[test]
    fn changes_are_written_at_their_places() {
        assert_eq!(text(MINE, &[]), MINE);
        let some = text(MINE, &[("k", "900 N/m"), ("low.f", "220 Hz"), ("left.gain", "20"), ("rate.sound", "96 kHz")]);
        let want = MINE.replace("\"2 kN/m\"", "\"900 N/m\"").replace("110 Hz", "220 Hz").replace("= 200 }", "= 20.0 }");
        assert!(some.starts_with(&want), "{some}");
        assert!(some[want.len()..].contains("[rate]\nsound = \"96 kHz\""), "{some}");
        // a value that the text leaves out
        let added = text(MINE, &[("bob.x", "1 mm")]);
        assert!(added.contains("# soft") && added.contains("x = \"1 mm\" }\n[REF]"), "{added}");
    }

    /// A change without one place gives a text written anew, which has the same model.
    #[test]
    fn a_change_without_a_place_is_written_too() {
        let hard = text(MINE, &[("preset", "hard")]);
        assert!(!hard.contains("# soft") && hard.contains("value = 4000"), "{hard}");
        let again = Loaded::read(&hard, "mine.ca.toml");
        assert!(again.diags.list.is_empty(), "{:?}", again.diags);
        assert_eq!(write::write(&again.model), hard);
    }
}
