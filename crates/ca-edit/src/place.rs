//! Places of values in the text of a model.

use ca_model::{Model, Value};
use core::fmt;

/// A place of a value in the text of a model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// keys from the root of the file to the value
    pub keys: Vec<String>,
    /// where it stands in a list, if in one
    pub index: Option<usize>,
}

impl Place {
    /// The place of these keys.
    pub fn keys<S: Into<String>>(keys: impl IntoIterator<Item = S>) -> Place {
        Place { keys: keys.into_iter().map(Into::into).collect(), index: None }
    }

    /// A key of what stands here.
    #[must_use]
    pub fn then(mut self, key: &str) -> Place {
        self.keys.push(key.into());
        self
    }

    /// The value of the parameter `name` of the whole model or of a part, whose parameters these are: at `owner`.
    pub fn param(owner: Place, name: &str, value: &Value) -> Place {
        let place = owner.then("param").then(name);
        if matches!(value, Value::Table(_)) { place.then("value") } else { place }
    }

    /// The number `key` of a module that is not of an instance.
    pub fn module(module: &str, kind: &str, key: &str) -> Place {
        let mut keys: Vec<String> = module.split('.').map(str::to_owned).collect();
        let leaf = keys.pop().unwrap_or_default();
        keys.extend([kind.to_owned(), leaf, key.to_owned()]);
        Place { keys, index: None }
    }

    /// The place of the number `name` of a model: a parameter, of the model or `instance.parameter`, or `module.key`.
    ///
    /// # Errors
    /// The number is not one number of the text: several instances share it.
    pub fn of(model: &Model, name: &str) -> Result<Place, NotOne> {
        if name.contains('[') {
            let why = format!("`{name}` is of several instances, whose numbers stand in lists; write it by hand");
            return Err(NotOne(why));
        }
        let param = model.params.iter().find(|e| e.key == name);
        if let Some(u) = model.uses.iter().find(|u| name.starts_with(&format!("{}.", u.name))) {
            if param.is_some() {
                return Ok(Place::keys(["use", &u.name, "with", &name[u.name.len() + 1..]]));
            }
            let why = format!("`{name}` is a number of a part; make it a parameter of the part, and vary that");
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

/// A number that the text does not have as one number; with the reason and a remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NotOne(String);

impl fmt::Display for NotOne {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl core::error::Error for NotOne {}
