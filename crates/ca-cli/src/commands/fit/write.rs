//! The text of a model with the numbers that were found; all else of it stays.
//!
//! Decides that a number keeps the unit its author gave it, and that one which many instances share is not touched.

use crate::commands::new;
use crate::outcome::Failure;
use ca_lab::fit::{Fit, Fitted};
use ca_model::{Model, Value, quantity};
use std::path::Path;
use toml_edit::{DocumentMut, Item};

/// Digits of a number that is written: a thousandth of a cent and better.
const DIGITS: usize = 8;

/// Refuses a path that cannot be written, before the work is done: with the messages that writing itself has.
pub(super) fn may_be(path: &Path, force: bool) -> Result<(), Failure> {
    new::may_be(path, force)?;
    if path.is_dir() {
        return Err(Failure::Failed(format!("`{}`: it is a directory; name a file in it", path.display())));
    }
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
    if folder.is_some_and(|f| !f.is_dir()) {
        let what = format!("`{}`: it cannot be written: no such directory", path.display());
        return Err(Failure::Failed(format!("{what}; make the directory first")));
    }
    Ok(())
}

/// The text of the model with what was found.
pub(super) fn text(model: &Model, found: &Fit) -> Result<String, Failure> {
    let mut doc: DocumentMut = model.text.parse().map_err(|e: toml_edit::TomlError| {
        Failure::Failed(format!("`{}`: it cannot be edited: {}", model.file, e.message()))
    })?;
    for f in &found.fitted {
        let path = path(model, &f.varied.name)?;
        if put(&mut doc, &path, f).is_none() {
            let what = format!("`{}`: `{}` cannot be written", f.varied.name, path.join("."));
            return Err(Failure::Failed(format!("{what}; write the number by hand")));
        }
    }
    Ok(doc.to_string())
}

/// The keys from the root of the file to a number.
pub(super) fn path(model: &Model, name: &str) -> Result<Vec<String>, Failure> {
    let words = |all: &[&str]| all.iter().map(|w| (*w).to_owned()).collect::<Vec<_>>();
    let of = |name: &str| model.uses.iter().find(|u| name.starts_with(&format!("{}.", u.name)));
    if name.contains('[') {
        let what = format!("`{name}` is of several instances, whose numbers stand in lists");
        return Err(Failure::Usage(format!("{what}; write it by hand")));
    }
    let is_param = model.params.iter().find(|e| e.key == name);
    if let Some(u) = of(name) {
        let rest = &name[u.name.len() + 1..];
        if is_param.is_some() {
            return Ok(words(&["use", &u.name, "with", rest]));
        }
        let what = format!("`{name}` is a number of a part");
        return Err(Failure::Usage(format!("{what}; make it a parameter of the part, and vary that")));
    }
    if let Some(e) = is_param {
        let mut path = words(&["param", name]);
        path.extend(matches!(e.value, Value::Table(_)).then(|| "value".to_owned()));
        return Ok(path);
    }
    let (owner, key) = name.rsplit_once('.').unwrap_or((name, ""));
    let kind = model.items.iter().find(|i| i.name == owner).map_or("", |i| i.kind.as_str());
    let mut path: Vec<String> = owner.split('.').map(str::to_owned).collect();
    let leaf = path.pop().unwrap_or_default();
    path.extend([kind.to_owned(), leaf, key.to_owned()]);
    Ok(path)
}

/// Writes a number at its place, or beside its fellows where it was not written.
fn put(doc: &mut DocumentMut, path: &[String], f: &Fitted) -> Option<()> {
    let (key, owners) = path.split_last()?;
    let mut at: &mut Item = doc.as_item_mut();
    for owner in owners {
        at = at.get_mut(owner.as_str())?;
    }
    // a bare number of a parameter is in the unit beside it
    let beside = at.get("unit").and_then(Item::as_str).map(str::to_owned);
    let table = at.as_table_like_mut()?;
    let old = table.get(key).and_then(Item::as_str).map(str::to_owned);
    let bare = table.get(key).is_some_and(|i| i.is_float() || i.is_integer());
    let unit = match &old {
        Some(t) => t.trim().split_once(char::is_whitespace).map(|(_, u)| u.trim().to_owned()),
        None => beside.filter(|_| bare && !f.varied.unit.is_empty()),
    };
    let size = unit.as_ref().and_then(|u| quantity::parse(&format!("1 {u}")).ok()).map(|q| q.value);
    let (unit, size) = unit.zip(size).unwrap_or_else(|| (f.varied.unit.clone(), 1.0));
    let v = quantity::rounded(f.value / size, DIGITS);
    let written = if bare || unit.is_empty() { format!("{v:?}") } else { format!("\"{v:?} {unit}\"") };
    let mut new: toml_edit::Value = written.parse().ok()?;
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(place) => {
            *new.decor_mut() = place.decor().clone();
            *place = new;
        }
        None => {
            table.insert(key, Item::Value(new));
        }
    }
    Some(())
}
