//! Text of the played model, as its take stores it.

use ca_lab::load::{self, Loaded};
use ca_lab::{Failure, bytes};
use ca_model::{Entry, Model, Value, write};

/// A model as a take stores it: its text, and the values changed since it was read.
pub struct Original {
    /// Model of the text.
    pub loaded: Loaded,
    /// Changed values, as names and values of `--set`.
    pub changes: Vec<(String, String)>,
    /// Model with these values.
    pub played: Loaded,
}

impl Original {
    /// Keeps the author's text if text and changes reproduce the same model to the byte. Otherwise writes a new text.
    ///
    /// The order of modules in a new text may differ, and with it the bits of the sound. So the model of the new text
    /// is played.
    ///
    /// # Errors
    /// Returns [`Failure::Found`] if the model has errors.
    pub fn of(loaded: &Loaded) -> Result<Original, Failure> {
        let model = &loaded.model;
        if !model.text.is_empty() {
            let original = if loaded.format.is_some() {
                Loaded::import(&model.text, &model.file)
            } else {
                load::read_again(model)
            };
            let changes = changes(&original.model, model);
            let mut changed = original.clone();
            let known = changes.iter().all(|(name, text)| changed.model.set(name, text));
            changed.look();
            // `bytes` refuses a model with findings of the reader
            if known && bytes::bytes(&changed).is_ok_and(|a| bytes::bytes(loaded).is_ok_and(|b| a == b)) {
                return Ok(Original { loaded: original, changes, played: loaded.clone() });
            }
        }
        bytes::bytes(loaded)?;
        let mut again = Loaded::read(&write::write(model), "model.ca.toml");
        again.clouds.clone_from(&loaded.clouds);
        Ok(Original { loaded: again.clone(), changes: Vec::new(), played: again })
    }
}

/// Values of `to` that are missing or different in `from`, by name.
fn changes(from: &Model, to: &Model) -> Vec<(String, String)> {
    let mut all = Vec::new();
    let mut put = |name: String, new: &Value, old: Option<&Value>| {
        if old != Some(new) {
            all.push((name, new.shown()));
        }
    };
    let find = |list: &[Entry], key: &str| list.iter().find(|e| e.key == key).map(|e| e.value.clone());
    for (owner, new, old) in [("model", &to.meta, &from.meta), ("rate", &to.rate, &from.rate)] {
        for e in new {
            put(format!("{owner}.{}", e.key), &e.value, find(old, &e.key).as_ref());
        }
    }
    let value = |v: Value| match v {
        Value::Table(entries) => find(&entries, "value"),
        v => Some(v),
    };
    for e in &to.params {
        if let Some(new) = value(e.value.clone()) {
            put(e.key.clone(), &new, find(&from.params, &e.key).and_then(value).as_ref());
        }
    }
    for item in &to.items {
        let old = from.items.iter().find(|i| i.name == item.name).map_or(&[][..], |i| &i.args);
        for e in &item.args {
            put(format!("{}.{}", item.name, e.key), &e.value, find(old, &e.key).as_ref());
        }
    }
    all
}
