//! The model: what an author writes, as plain data.
//!
//! Decides that all of it stands in one file, parts included: a part holds a model of its own, and a model holds parts. What
//! reads, writes or changes models stands above.

use crate::quantity;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// More modules (MATs and LIAs) than this are refused before any is made: a slip of a digit should not eat the machine,
/// and no machine plays a tenth of them in real time.
pub const LARGEST: usize = 1_000_000;

/// Byte range in the source text; [`Span::NONE`] for models that were built, not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Span {
    /// first byte
    pub start: usize,
    /// one past the last byte
    pub end: usize,
}

impl Span {
    /// "nowhere": the model was built by a program.
    pub const NONE: Span = Span { start: usize::MAX, end: usize::MAX };

    /// True unless this is [`Span::NONE`].
    pub fn is_some(self) -> bool {
        self != Span::NONE
    }
}

/// A value as written.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// a bare number, in the model's units
    Num(f64),
    /// a quoted string: a quantity, a name, a choice or text, depending on where it stands
    Text(String),
    /// `true`, `false`
    Bool(bool),
    /// `[ … ]`
    List(Vec<Entry>),
    /// `{ … }`; each entry has its key
    Table(Vec<Entry>),
}

/// A value with its key and where both stand. Members of a list have an empty key.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// the key; empty in lists
    pub key: String,
    /// where the key stands
    pub key_span: Span,
    /// the value as written
    pub value: Value,
    /// where the value stands
    pub span: Span,
}

impl Entry {
    /// An entry built by a program.
    pub fn new(key: &str, value: impl Into<Value>) -> Entry {
        Entry { key: key.into(), key_span: Span::NONE, value: value.into(), span: Span::NONE }
    }
}

impl Value {
    /// What somebody means who types this: a number, a flag, or text such as a quantity.
    pub fn typed(text: &str) -> Value {
        let text = text.trim();
        match (text.parse::<f64>(), text) {
            (Ok(v), _) => Value::Num(v),
            (_, "true") => Value::Bool(true),
            (_, "false") => Value::Bool(false),
            _ => Value::Text(text.into()),
        }
    }

    /// As a number in SI units, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Value::Num(v) => Some(*v),
            Value::Text(t) => quantity::parse(t).ok().map(|q| q.value),
            _ => None,
        }
    }

    /// The text that gives this value where it is typed.
    pub fn shown(&self) -> String {
        match self {
            Value::Num(v) => v.to_string(),
            Value::Text(t) => t.clone(),
            Value::Bool(b) => b.to_string(),
            Value::List(v) => format!("[{}]", v.iter().map(|e| e.value.shown()).collect::<Vec<_>>().join(", ")),
            Value::Table(v) => {
                let one = v.iter().map(|e| format!("{} = {}", e.key, e.value.shown()));
                format!("{{{}}}", one.collect::<Vec<_>>().join(", "))
            }
        }
    }
}

impl From<f64> for Value {
    fn from(v: f64) -> Value {
        Value::Num(v)
    }
}
impl From<&str> for Value {
    fn from(v: &str) -> Value {
        Value::Text(v.into())
    }
}
impl From<String> for Value {
    fn from(v: String) -> Value {
        Value::Text(v)
    }
}
impl From<bool> for Value {
    fn from(v: bool) -> Value {
        Value::Bool(v)
    }
}
impl<T: Into<Value>> From<Vec<T>> for Value {
    fn from(v: Vec<T>) -> Value {
        Value::List(v.into_iter().map(|x| Entry::new("", x)).collect())
    }
}

/// One named module: a MAT, a LIA, a port or a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// the section it stands in, e.g. `MAS`
    pub kind: String,
    /// where the kind is written
    pub kind_span: Span,
    /// full name; members of a group carry its name and a dot
    pub name: String,
    /// where the name is written
    pub name_span: Span,
    /// index into [`Model::groups`], if it is a member of one
    pub group: Option<usize>,
    /// the parameters written, in order
    pub args: Vec<Entry>,
    /// the whole value
    pub span: Span,
}

/// A lower-case table: modules that share a medium (and later a dimension).
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// its name
    pub name: String,
    /// where the name is written
    pub span: Span,
    /// its own properties, e.g. `gravity`
    pub props: Vec<Entry>,
}

/// A model as its author wrote it. Root tables are kept as entries; the compiler gives them meaning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// name of the file it was read from, for reports; may be empty
    pub file: String,
    /// the source text the spans point into; empty for built models
    pub text: String,
    /// the comment block at the head of the file, without its `#`
    pub header: String,
    /// `[model]`: title, units, reference_rate, gravity, friction
    pub meta: Vec<Entry>,
    /// `[rate]`: sound, oversample, gesture, border, latency, feedback, filter
    pub rate: Vec<Entry>,
    /// `[param]`: name = value or { value, unit, live, min, max, doc }
    pub params: Vec<Entry>,
    /// `[gesture]`: port or live parameter = list of [time, value]
    pub gestures: Vec<Entry>,
    /// `[equivalence]`: quantity = [real, simulated]
    pub equivalence: Vec<Entry>,
    /// `[part.NAME]`: pieces that are used many times, as written
    pub parts: Vec<Part>,
    /// `[use]`: instances of parts, as written; their modules are among the others
    pub uses: Vec<Use>,
    /// the other files that parts were taken from
    pub files: Vec<SourceFile>,
    /// groups in document order
    pub groups: Vec<Group>,
    /// modules in document order
    pub items: Vec<Item>,
    /// names that stand in the text, but in a place or a form that could not be read; that has been reported, so a
    /// reference to one of them is not reported again
    pub lost: Vec<String>,
}

impl Model {
    /// Adds a module; the builder's one entry point. `name` must be unique (the compiler reports it otherwise).
    ///
    /// ```
    /// use ca_model::{Entry, Model, Value};
    /// let mut m = Model::default();
    /// m.add("MAS", "bob", [Entry::new("m", "1 g"), Entry::new("dx0", "1 mm")]);
    /// m.add("SOL", "wall", []);
    /// m.add("RES", "spring", [Entry::new("between", Value::from(vec!["wall", "bob"])), Entry::new("k", "40 N/m")]);
    /// assert_eq!(m.items.len(), 3);
    /// ```
    pub fn add(&mut self, kind: &str, name: &str, args: impl IntoIterator<Item = Entry>) -> &mut Self {
        self.items.push(Item {
            kind: kind.into(),
            kind_span: Span::NONE,
            name: name.into(),
            name_span: Span::NONE,
            group: None,
            args: args.into_iter().collect(),
            span: Span::NONE,
        });
        self
    }

    /// Sets a parameter from text, as `--set` does: `hammer.m` of a module, or the name of a `[param]`. Numbers and
    /// quantities are taken as such, `true`/`false` as flags, anything else as text; the compiler checks them like any
    /// other, but their findings point nowhere: what is set does not stand in the text. Returns false where there is
    /// no such name.
    pub fn set(&mut self, name: &str, text: &str) -> bool {
        self.put(name, Value::typed(text))
    }

    /// As [`Model::set`], with any value.
    pub fn put(&mut self, name: &str, value: Value) -> bool {
        if let Some(e) = self.params.iter_mut().find(|e| e.key == name) {
            if let Value::Table(entries) = &mut e.value {
                let value = in_its_unit(entries, value);
                entries.retain(|x| x.key != "value");
                entries.push(Entry::new("value", value));
            } else {
                (e.value, e.span) = (value, Span::NONE);
            }
            return true;
        }
        let Some((owner, key)) = name.rsplit_once('.') else { return false };
        if matches!(owner, "model" | "rate") {
            let section = if owner == "model" { &mut self.meta } else { &mut self.rate };
            section.retain(|e| e.key != key);
            section.push(Entry::new(key, value));
            return true;
        }
        let Some(item) = self.items.iter_mut().find(|i| i.name == owner) else { return false };
        if let (whole, Some(at)) = in_list(key) {
            let list = item.args.iter_mut().find(|e| e.key == whole).map(|e| &mut e.value);
            let Some(Value::List(list)) = list else { return false };
            let Some(e) = list.get_mut(at) else { return false };
            (e.value, e.span) = (value, Span::NONE);
            return true;
        }
        match item.args.iter_mut().find(|e| e.key == key) {
            Some(e) => (e.value, e.span) = (value, Span::NONE),
            None => item.args.push(Entry::new(key, value)),
        }
        true
    }

    /// The value of `key` in `[model]`, if written.
    pub fn meta(&self, key: &str) -> Option<&Entry> {
        self.meta.iter().find(|e| e.key == key)
    }

    /// The `title` of `[model]`, or an empty string.
    pub fn title(&self) -> &str {
        match self.meta("title").map(|e| &e.value) {
            Some(Value::Text(t)) => t,
            _ => "",
        }
    }
}

/// `f[1]` → `f` and 1: one value of a list.
pub fn in_list(key: &str) -> (&str, Option<usize>) {
    match key.strip_suffix(']').and_then(|k| k.split_once('[')) {
        Some((whole, at)) => at.parse().map_or((key, None), |at| (whole, Some(at))),
        None => (key, None),
    }
}

/// A bare number for a parameter that is written in a unit is one of SI: its range has that unit, too.
fn in_its_unit(written: &[Entry], value: Value) -> Value {
    let Value::Num(v) = value else { return value };
    let unit = |e: &Entry| match &e.value {
        Value::Text(t) if e.key != "doc" => {
            quantity::parse(t).ok().filter(|q| q.has_unit).map(|q| quantity::unit_of(q.dim))
        }
        _ => None,
    };
    if written.iter().any(|e| e.key == "unit") {
        return value;
    }
    written.iter().find_map(unit).map_or(value, |unit| Value::Text(format!("{v:e} {unit}")))
}

/// `[part.NAME]`, as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// its name
    pub name: String,
    /// where the name is written
    pub span: Span,
    /// one line for people
    pub doc: String,
    /// properties of the group that each instance is
    pub props: Vec<Entry>,
    /// its parameters, modules, groups, gestures and the parts it uses
    pub body: Model,
}

/// A line of `[use]`, as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// name of the instance, or of all of them
    pub name: String,
    /// where the name is written
    pub span: Span,
    /// name of the part; of a whole file there is none
    pub part: Option<Entry>,
    /// the file it stands in, if it is another one, from the folder of this
    pub file: Option<Entry>,
    /// how many; without it there is one, whose modules have no index
    pub n: Option<Entry>,
    /// values of its parameters; where there are many, a list has one for each
    pub with: Vec<Entry>,
}

impl Use {
    /// One instance, called so, of a part that is handed over with it.
    pub fn new(name: &str) -> Use {
        Use { name: name.into(), span: Span::NONE, part: None, file: None, n: None, with: Vec::new() }
    }
}

/// A file that a model takes parts from.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    /// as it is named, from the folder of the model
    pub name: String,
    /// its text
    pub text: String,
    /// the place of its first byte among all spans of the model
    pub start: usize,
}
