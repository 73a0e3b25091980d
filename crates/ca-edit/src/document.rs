//! Text of a model whose values can be changed. All bytes outside a change stay.

use crate::layout::{Layout, key, quoted};
use crate::paths::Paths;
use crate::tree::{Content, Node, Pair, Tree};
use crate::{Edited, Place, TextEdit};
use ca_model::render::line_column;
use core::fmt;

/// Error for a text that is not TOML, with the place and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable(String);

impl Unreadable {
    pub(crate) fn new(text: &str, at: Option<usize>, why: &str) -> Unreadable {
        let (line, column) = line_column(text, at.unwrap_or(text.len()));
        Unreadable(format!("line {line}, column {column}: {why}"))
    }
}

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
    fn of(node: &Node) -> Option<Value> {
        match &node.content {
            Content::Number(v) => Some(Value::Number(*v)),
            Content::Text(t) => Some(Value::Text(t.clone())),
            Content::List(all) => all.iter().map(Value::of).collect::<Option<_>>().map(Value::List),
            Content::Bool | Content::Table(_) | Content::Other => None,
        }
    }

    pub(crate) fn written(&self) -> String {
        match self {
            Value::Number(v) if v.is_nan() => "nan".into(),
            Value::Number(v) => format!("{v:?}"),
            Value::Text(text) => quoted(text),
            Value::List(all) => format!("[{}]", all.iter().map(Value::written).collect::<Vec<_>>().join(", ")),
        }
    }
}

/// Text of a model, which can be edited.
#[derive(Clone, Debug)]
pub struct Document {
    text: String,
    tree: Tree,
}

impl Document {
    /// Parses a text.
    ///
    /// # Errors
    /// Fails if the text is not TOML.
    pub fn read(text: &str) -> Result<Document, Unreadable> {
        Ok(Document { tree: Tree::read(text)?, text: text.into() })
    }

    /// Returns the text.
    pub fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn tree(&self) -> &Tree {
        &self.tree
    }

    pub(crate) fn layout(&self) -> Layout<'_> {
        Layout { text: &self.text, tree: &self.tree, catalog: None }
    }

    /// Returns the value at a place; `None` if the place is empty or a table.
    pub fn value(&self, place: &Place) -> Option<Value> {
        Value::of(self.node(place)?)
    }

    pub(crate) fn node(&self, place: &Place) -> Option<&Node> {
        let node = &self.tree.pair(&place.keys)?.value;
        match (place.index, &node.content) {
            (None, _) => Some(node),
            (Some(k), Content::List(all)) => all.get(k),
            _ => None,
        }
    }

    /// Returns the keys of the table at a place, in the order of the text. Without a table the list is empty.
    pub fn keys(&self, place: &Place) -> Vec<&str> {
        self.tree.keys(&place.keys)
    }

    /// Replaces the value at a place, or adds it to the table of the place; blanks and comments around it stay. Returns
    /// `None` without such a table or list.
    pub fn set(&mut self, place: &Place, value: &Value) -> Option<()> {
        let (_, owner) = place.keys.split_last()?;
        if !self.tree.is_table(owner) {
            return None;
        }
        self.insert(place, value)
    }

    /// Acts as [`Document::set`], and creates missing tables. Returns `None` if one of them is not a table.
    pub fn insert(&mut self, place: &Place, value: &Value) -> Option<()> {
        self.write(place, &value.written())
    }

    /// Writes a value as TOML. It creates missing tables, and replaces a value but not a section.
    pub(crate) fn write(&mut self, place: &Place, toml: &str) -> Option<()> {
        if place.index.is_some() {
            let range = self.node(place)?.range.clone();
            return self.apply(vec![TextEdit::new(range, toml)]);
        }
        let edit = self.layout().set(&place.keys, toml)?;
        self.apply(vec![edit])
    }

    /// Creates the missing tables of a path. Returns `None` if one of them is not a table.
    pub fn make(&mut self, keys: &[String]) -> Option<()> {
        if self.tree.is_table(keys) {
            return Some(());
        }
        match (1..=keys.len()).find_map(|n| self.tree.pair(&keys[..n])) {
            Some(Pair { path, value: Node { content: Content::Table(_), .. }, .. }) if path.len() < keys.len() => {
                self.write(&Place::keys(keys), "{}")
            }
            Some(_) => None,
            None => {
                let at = self.layout().after_relatives(keys);
                let edit = self.layout().section(keys, "", at);
                self.apply(vec![edit])
            }
        }
    }

    /// Removes the value or table at a place, or one value of a list; its section stays. Returns `None` if the place is
    /// empty.
    pub fn clear(&mut self, place: &Place) -> Option<()> {
        if let Some(k) = place.index {
            let list = &self.tree.pair(&place.keys)?.value;
            let edit = self.layout().remove_member(list, k)?;
            return self.apply(vec![edit]);
        }
        let edits = self.layout().remove_entries(&Paths::from_iter([place.keys.clone()]), false);
        if edits.is_empty() { None } else { self.apply(edits) }
    }

    /// Renames the entry at a place. Returns `None` if it is missing or `name` is taken.
    pub fn rename(&mut self, place: &Place, name: &str) -> Option<()> {
        let (_, owner) = place.keys.split_last()?;
        if place.index.is_some() || self.tree.keys(owner).contains(&name) {
            return None;
        }
        let mut edits = Vec::new();
        self.tree.words(&mut |path, word| {
            if path == place.keys {
                edits.push(TextEdit::new(word.range.clone(), key(name)));
            }
        });
        if edits.is_empty() { None } else { self.apply(edits) }
    }

    /// Applies replacements. Returns `None`, and changes nothing, if the result is not TOML.
    pub(crate) fn apply(&mut self, edits: Vec<TextEdit>) -> Option<()> {
        let text = Edited::new(&self.text, edits).text;
        *self = Document::read(&text).ok()?;
        Some(())
    }
}

impl fmt::Display for Document {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MINE: &str =
        "# mine\ntitle = \"a\" # the title\n\n[CEL] # cells\nb = { m = \"1 g\" }\na = { f = [ 1, 2.5 ] }\n";

    fn changed(change: impl FnOnce(&mut Document) -> Option<()>) -> Option<String> {
        of(MINE, change)
    }

    fn of(text: &str, change: impl FnOnce(&mut Document) -> Option<()>) -> Option<String> {
        let mut text = Document::read(text).unwrap();
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
        assert_eq!(changed(|t| t.clear(&one)).unwrap(), MINE.replace("[ 1, 2.5 ]", "[ 1 ]"));
        let gone = changed(|t| t.clear(&Place::keys(["CEL", "b"]))).unwrap();
        assert_eq!(gone, MINE.replace("b = { m = \"1 g\" }\n", ""));
        let named = changed(|t| t.rename(&Place::keys(["CEL", "b"]), "c")).unwrap();
        assert_eq!(Document::read(&named).unwrap().keys(&Place::keys(["CEL"])), ["c", "a"]);
        let made =
            changed(|t| t.insert(&Place::keys(["x", "y", "z"]), &Value::List(vec![Value::Number(1.0)]))).unwrap();
        assert!(made.starts_with(MINE) && made.contains("[x.y]\nz = [1.0]"), "{made}");
    }

    /// Dotted keys, sections and line ends stay as their author wrote them.
    #[test]
    fn entries_are_added_in_the_style_of_their_neighbours() {
        let two = |v| Value::Number(v);
        let add =
            |text: &str, path: &[&str]| of(text, |t| t.insert(&Place::keys(path.iter().copied()), &two(2.0))).unwrap();
        let dots = "[use.t]\r\npart = 'x'\r\nwith.f = 1 # a\r\nn = 7";
        assert_eq!(add(dots, &["use", "t", "with", "g"]), dots.replace("# a\r\n", "# a\r\nwith.g = 2.0\r\n"));
        assert_eq!(add(dots, &["use", "t", "m"]), format!("{dots}\r\nm = 2.0\r\n"));
        assert_eq!(add("[a]\nb = {}\n", &["a", "b", "c"]), "[a]\nb = { c = 2.0 }\n");
        assert_eq!(add("[a]\nb = { c.d = 1 }\n", &["a", "b", "c", "e"]), "[a]\nb = { c.d = 1, c.e = 2.0 }\n");
        assert_eq!(add("[a]\nb = { d = 1, }\n", &["a", "b", "c", "e"]), "[a]\nb = { d = 1, c = { e = 2.0 }, }\n");
        assert_eq!(add("[a.b]\nc = 1\n\n[d]\n", &["a", "e", "f"]), "[a.b]\nc = 1\n\n[a.e]\nf = 2.0\n\n[d]\n");
        assert_eq!(add("[a]\n  c = 1\n", &["a", "d"]), "[a]\n  c = 1\n  d = 2.0\n");
        assert_eq!(add("", &["a", "b"]), "[a]\nb = 2.0\n");
        assert_eq!(add("[a]\n", &["b"]), "b = 2.0\n[a]\n");
    }

    #[test]
    fn entries_are_removed_with_their_line() {
        let clear = |text: &str, path: &[&str]| of(text, |t| t.clear(&Place::keys(path.iter().copied())));
        assert_eq!(clear("[a]\nb = 1 # x\n\n[c]\nd = 2\n", &["a", "b"]).unwrap(), "[a]\n\n[c]\nd = 2\n");
        assert_eq!(clear("[a] # x\nb = 1\n", &["a", "b"]).unwrap(), "[a] # x\n");
        assert_eq!(clear("[a]\n# x\nb = 1\n", &["a", "b"]).unwrap(), "[a]\n# x\n");
        assert_eq!(clear("a = { b = 1, c = 2, d = 3 }", &["a", "c"]).unwrap(), "a = { b = 1, d = 3 }");
        assert_eq!(clear("a = { b = 1, c = 2 }", &["a", "b"]).unwrap(), "a = { c = 2 }");
        assert_eq!(clear("a = { b = 1, }", &["a", "b"]).unwrap(), "a = {  }");
        assert_eq!(clear("[a.b]\nc = 1\n[a.b.d]\ne = 1\n[f]\n", &["a", "b"]).unwrap(), "[f]\n");
        assert_eq!(clear("[a]\nb.c = 1\nb.d = 2\ne = 3\n", &["a", "b"]).unwrap(), "[a]\ne = 3\n");
    }

    #[test]
    fn a_place_that_is_not_there_is_refused() {
        let none = Place::keys(["CEL", "none", "m"]);
        assert_eq!(changed(|t| t.set(&none, &Value::Number(1.0))), None);
        assert_eq!(changed(|t| t.clear(&none)), None);
        assert_eq!(changed(|t| t.insert(&Place::keys(["title", "x"]), &Value::Number(1.0))), None);
        assert_eq!(changed(|t| t.insert(&Place::keys(["CEL"]), &Value::Number(1.0))), None);
        assert_eq!(changed(|t| t.rename(&Place::keys(["CEL", "b"]), "a")), None);
        for index in [2, usize::MAX] {
            let beyond = Place { index: Some(index), ..Place::keys(["CEL", "a", "f"]) };
            assert_eq!(changed(|t| t.set(&beyond, &Value::Number(1.0))), None);
            assert_eq!(changed(|t| t.clear(&beyond)), None);
        }
        let broken = Document::read("a = 1\nb = ").unwrap_err().to_string();
        assert!(broken.starts_with("cannot edit the text: line 2, column "), "{broken}");
    }
}
