//! Writes fitted numbers into the text of a model and leaves everything else unchanged.
//!
//! A number keeps the unit chosen by its author. A number shared by several instances is not changed.

use crate::commands::new;
use crate::outcome::Failure;
use ca_edit::{Document, Place, number};
use ca_fit::Fit;
use ca_model::Model;
use std::path::Path;

/// Digits of a written number: better than a thousandth of a cent.
const DIGITS: usize = 8;

/// Refuses a path that cannot be written before the work begins, with the same messages as writing.
pub(super) fn may_be(path: &Path, force: bool) -> Result<(), Failure> {
    new::may_be(path, force)?;
    if path.is_dir() {
        return Err(Failure::Failed(format!("`{}` is a directory; name a file in it", path.display())));
    }
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    if folder.is_some_and(|f| !f.is_dir()) {
        let what = format!("`{}` cannot be written: no such directory", path.display());
        return Err(Failure::Failed(format!("{what}; make the directory first")));
    }
    Ok(())
}

pub(super) fn text(model: &Model, found: &Fit) -> Result<String, Failure> {
    let mut text = Document::read(&model.text).map_err(|e| Failure::Failed(format!("`{}`: {e}", model.file)))?;
    for f in &found.fitted {
        let place = place(model, &f.varied.name)?;
        if number::write(&mut text, &place, f.value, &f.varied.unit, DIGITS).is_none() {
            let what = format!("`{}`: `{place}` cannot be written", f.varied.name);
            return Err(Failure::Failed(format!("{what}; write the number by hand")));
        }
    }
    Ok(text.to_string())
}

pub(super) fn place(model: &Model, name: &str) -> Result<Place, Failure> {
    Place::of(model, name).map_err(|e| Failure::Usage(e.to_string()))
}
