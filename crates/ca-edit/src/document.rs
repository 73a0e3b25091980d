//! Model text as a tree whose values can be changed.

use crate::Place;
use core::fmt;
use toml_edit::{Array, DocumentMut, Item, Table, TableLike};

/// Error for a text that is not TOML, with the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable(String);

impl fmt::Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot edit the text: {}", self.0)
    }
}

impl core::error::Error for Unreadable {}

/// A TOML value of the text.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Number without a unit.
    Number(f64),
    /// Word or quantity.
    Text(String),
    /// List of values.
    List(Vec<Value>),
}

impl Value {
    fn of(value: &toml_edit::Value) -> Option<Value> {
        if let Some(text) = value.as_str() {
            return Some(Value::Text(text.to_owned()));
        }
        if let Some(list) = value.as_array() {
            return list.iter().map(Value::of).collect::<Option<_>>().map(Value::List);
        }
        value.as_float().or(value.as_integer().map(|i| i as f64)).map(Value::Number)
    }

    fn written(&self) -> toml_edit::Value {
        match self {
            // `toml_edit` writes 1e99 with all its zeros
            Value::Number(v) => format!("{v:?}").parse().unwrap_or_else(|_| (*v).into()),
            Value::Text(text) => text.as_str().into(),
            Value::List(all) => all.iter().map(Value::written).collect::<Array>().into(),
        }
    }
}

/// Text of a model, which can be edited.
#[derive(Clone, Debug)]
pub struct Document(DocumentMut);

impl Document {
    /// Parses a text.
    ///
    /// # Errors
    /// Fails if the text is not TOML.
    pub fn read(text: &str) -> Result<Document, Unreadable> {
        let read = text.parse().map_err(|e: toml_edit::TomlError| Unreadable(e.message().to_owned()))?;
        Ok(Document(read))
    }

    /// Returns the value at a place; `None` if the place is empty or a table.
    pub fn value(&self, place: &Place) -> Option<Value> {
        let item = place.keys.iter().try_fold(self.0.as_item(), |at, key| at.get(key.as_str()))?;
        Value::of(match place.index {
            Some(k) => item.as_array()?.get(k)?,
            None => item.as_value()?,
        })
    }

    /// Returns the keys of the table at a place, in the order of the text. Without a table the list is empty.
    pub fn keys(&self, place: &Place) -> Vec<&str> {
        let item = place.keys.iter().try_fold(self.0.as_item(), |at, key| at.get(key.as_str()));
        let table = item.and_then(Item::as_table_like);
        table.map_or_else(Vec::new, |t| t.iter().map(|(key, _)| key).collect())
    }

    /// Replaces the value at a place, or adds it to the table of the place; blanks and comments around it stay. Returns
    /// `None` without such a table or list.
    pub fn set(&mut self, place: &Place, value: &Value) -> Option<()> {
        let mut new = value.written();
        if let Some(old) = self.value_mut(place) {
            *new.decor_mut() = old.decor().clone();
            *old = new;
            return Some(());
        }
        let (key, owner) = place.keys.split_last()?;
        if place.index.is_some() {
            return None;
        }
        self.table_mut(owner)?.insert(key, Item::Value(new));
        Some(())
    }

    /// Acts as [`Document::set`], and creates missing tables. Returns `None` if one of them is not a table.
    pub fn insert(&mut self, place: &Place, value: &Value) -> Option<()> {
        let (_, owner) = place.keys.split_last()?;
        self.make(owner)?;
        self.set(place, value)
    }

    /// Creates the missing tables of a path. Returns `None` if one of them is not a table.
    pub fn make(&mut self, keys: &[String]) -> Option<()> {
        let mut at: &mut dyn TableLike = self.0.as_table_mut();
        for key in keys {
            at = at.entry(key).or_insert_with(|| Item::Table(Table::new())).as_table_like_mut()?;
        }
        Some(())
    }

    /// Removes the value or table at a place, or one value of a list. Returns `None` if the place is empty.
    pub fn clear(&mut self, place: &Place) -> Option<()> {
        if let Some(k) = place.index {
            let list = self.item_mut(&place.keys)?.as_array_mut()?;
            return (k < list.len()).then(|| _ = list.remove(k));
        }
        let (key, owner) = place.keys.split_last()?;
        self.table_mut(owner)?.remove(key).map(|_| ())
    }

    /// Renames the entry at a place and moves it to the end of its table. Returns `None` if it is missing or `name` is
    /// taken.
    pub fn rename(&mut self, place: &Place, name: &str) -> Option<()> {
        let (key, owner) = place.keys.split_last()?;
        let table = self.table_mut(owner)?;
        if place.index.is_some() || table.contains_key(name) {
            return None;
        }
        let item = table.remove(key)?;
        table.insert(name, item);
        Some(())
    }

    fn item_mut(&mut self, keys: &[String]) -> Option<&mut Item> {
        // `Item::get_mut` would insert missing keys
        keys.iter().try_fold(self.0.as_item_mut(), |at, key| at.as_table_like_mut()?.get_mut(key))
    }

    fn table_mut(&mut self, keys: &[String]) -> Option<&mut dyn TableLike> {
        self.item_mut(keys)?.as_table_like_mut()
    }

    fn value_mut(&mut self, place: &Place) -> Option<&mut toml_edit::Value> {
        let item = self.item_mut(&place.keys)?;
        match place.index {
            Some(k) => item.as_array_mut()?.get_mut(k),
            None => item.as_value_mut(),
        }
    }
}

impl fmt::Display for Document {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINE: &str =
        "# mine\ntitle = \"a\" # the title\n\n[CEL] # cells\nb = { m = \"1 g\" }\na = { f = [ 1, 2.5 ] }\n";

    fn changed(change: impl FnOnce(&mut Document) -> Option<()>) -> Option<String> {
        let mut text = Document::read(MINE).unwrap();
        change(&mut text).map(|()| text.to_string())
    }

    #[test]
    fn what_is_not_changed_stays() {
        assert_eq!(changed(|_| Some(())).unwrap(), MINE);
        let title = Place::keys(["title"]);
        let set = changed(|t| t.set(&title, &Value::Text("b \"c\"".into()))).unwrap();
        assert_eq!(set, MINE.replace("\"a\"", "'b \"c\"'"));
        let one = Place { index: Some(1), ..Place::keys(["CEL", "a", "f"]) };
        assert_eq!(changed(|t| t.set(&one, &Value::Number(1e99))).unwrap(), MINE.replace("2.5", "1e99"));
        assert_eq!(changed(|t| t.clear(&one)).unwrap(), MINE.replace("[ 1, 2.5 ]", "[ 1]"));
        let gone = changed(|t| t.clear(&Place::keys(["CEL", "b"]))).unwrap();
        assert_eq!(gone, MINE.replace("b = { m = \"1 g\" }\n", ""));
        let named = changed(|t| t.rename(&Place::keys(["CEL", "b"]), "c")).unwrap();
        assert_eq!(Document::read(&named).unwrap().keys(&Place::keys(["CEL"])), ["a", "c"]);
        let made =
            changed(|t| t.insert(&Place::keys(["x", "y", "z"]), &Value::List(vec![Value::Number(1.0)]))).unwrap();
        assert!(made.starts_with(MINE) && made.contains("[x.y]\nz = [1.0]"), "{made}");
    }

    #[test]
    fn a_place_that_is_not_there_is_refused() {
        let none = Place::keys(["CEL", "none", "m"]);
        assert_eq!(changed(|t| t.set(&none, &Value::Number(1.0))), None);
        assert_eq!(changed(|t| t.clear(&none)), None);
        assert_eq!(changed(|t| t.insert(&Place::keys(["title", "x"]), &Value::Number(1.0))), None);
        assert_eq!(changed(|t| t.rename(&Place::keys(["CEL", "b"]), "a")), None);
        for index in [2, usize::MAX] {
            let beyond = Place { index: Some(index), ..Place::keys(["CEL", "a", "f"]) };
            assert_eq!(changed(|t| t.set(&beyond, &Value::Number(1.0))), None);
            assert_eq!(changed(|t| t.clear(&beyond)), None);
        }
        assert!(Document::read("a = ").unwrap_err().to_string().starts_with("cannot edit the text: "));
    }
}
