//! Places of values in the text of a model.

use ca_model::{Model, Value};
use core::fmt;

/// Place of a value in the text of a model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Keys from the root of the file to the value.
    pub keys: Vec<String>,
    /// Index in a list, if the value is in one.
    pub index: Option<usize>,
}

impl Place {
    /// Builds a place from its keys.
    pub fn keys<S: Into<String>>(keys: impl IntoIterator<Item = S>) -> Place {
        Place { keys: keys.into_iter().map(Into::into).collect(), index: None }
    }

    /// Appends a key.
    #[must_use]
    pub fn then(mut self, key: &str) -> Place {
        self.keys.push(key.into());
        self
    }

    /// Returns the place of the parameter `name` of the model or the part at `owner`; `value` is its present value.
    pub fn param(owner: Place, name: &str, value: &Value) -> Place {
        let place = owner.then("param").then(name);
        if matches!(value, Value::Table(_)) { place.then("value") } else { place }
    }

    /// Returns the place of the number `key` of a module that does not belong to an instance.
    pub fn module(module: &str, kind: &str, key: &str) -> Place {
        let mut keys: Vec<String> = module.split('.').map(str::to_owned).collect();
        let leaf = keys.pop().unwrap_or_default();
        keys.extend([kind.to_owned(), leaf, key.to_owned()]);
        Place { keys, index: None }
    }

    /// Finds the place of the number `name`: a parameter, `instance.parameter` or `module.key`.
    ///
    /// # Errors
    /// Fails if several instances share the number, or if it is a number of a part.
    pub fn of(model: &Model, name: &str) -> Result<Place, NotOne> {
        if name.contains('[') {
            let why =
                format!("`{name}` belongs to several instances, whose values are in lists; edit the file by hand");
            return Err(NotOne(why));
        }
        let param = model.params.iter().find(|e| e.key == name);
        if let Some(u) = model.uses.iter().find(|u| name.starts_with(&format!("{}.", u.name))) {
            if param.is_some() {
                return Ok(Place::keys(["use", &u.name, "with", &name[u.name.len() + 1..]]));
            }
            let why = format!("`{name}` is a number in a part; make it a parameter of the part, and vary this");
            return Err(NotOne(why));
        }
        if let Some(e) = param {
            return Ok(Place::param(Place::default(), name, &e.value));
        }
        let (module, key) = name.rsplit_once('.').unwrap_or((name, ""));
        let kind = model.items.iter().find(|i| i.name == module).map_or("", |i| i.kind.as_str());
        Ok(Place::module(module, kind, key))
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.keys.join("."))?;
        self.index.map_or(Ok(()), |k| write!(f, "[{k}]"))
    }
}

/// Error for a number that is not one number of the text, with the reason and a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotOne(String);

impl fmt::Display for NotOne {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl core::error::Error for NotOne {}
