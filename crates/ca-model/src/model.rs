//! The model: what an author writes, as plain data.
//!
//! All its types are in this file, because a part contains a model and a model contains parts. Modules that read, write
//! or change models depend on this one.

use crate::quantity;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::internal::scene::PRESET;

/// Largest number of modules (MATs and LIAs) of a model; more are refused before any is made. A wrong digit must not
/// exhaust the machine, and a tenth of this is already too slow for real time on any machine.
pub const LARGEST: usize = 1_000_000;

/// Byte range in the source text, or [`Span::NONE`] in models built by a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// Marks a missing place: the model was built by a program.
    pub const NONE: Span = Span { start: usize::MAX, end: usize::MAX };

    /// Returns true unless this is [`Span::NONE`].
    pub fn is_some(self) -> bool {
        self != Span::NONE
    }
}

/// Value as written.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Bare number, in the units of the model.
    Num(f64),
    /// Quoted string: depending on its place a quantity, a name, a choice or text.
    Text(String),
    /// `true` or `false`.
    Bool(bool),
    /// `[ … ]`.
    List(Vec<Entry>),
    /// `{ … }`; each entry has its key.
    Table(Vec<Entry>),
}

/// Value with its key and their places. Members of a list have an empty key.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Key; empty in lists.
    pub key: String,
    /// Place of the key.
    pub key_span: Span,
    /// Value as written.
    pub value: Value,
    /// Place of the value.
    pub span: Span,
}

impl Entry {
    /// Makes an entry without a place.
    pub fn new(key: &str, value: impl Into<Value>) -> Entry {
        Entry { key: key.into(), key_span: Span::NONE, value: value.into(), span: Span::NONE }
    }

    /// Gives a line of `[param]` another value, written at `span`. A bare number has the unit of the parameter.
    pub fn set_value(&mut self, value: Value, span: Span) {
        if let Value::Table(entries) = &mut self.value {
            let value = in_its_unit(entries, value);
            entries.retain(|x| x.key != "value");
            entries.push(Entry { span, ..Entry::new("value", value) });
        } else {
            (self.value, self.span) = (value, span);
        }
    }
}

impl Value {
    /// Interprets typed text: a number, a flag, or text such as a quantity.
    pub fn typed(text: &str) -> Value {
        let text = text.trim();
        match (text.parse::<f64>(), text) {
            (Ok(v), _) => Value::Num(v),
            (_, "true") => Value::Bool(true),
            (_, "false") => Value::Bool(false),
            _ => Value::Text(text.into()),
        }
    }

    /// Returns the number in SI units, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Value::Num(v) => Some(*v),
            Value::Text(t) => quantity::parse(t).ok().map(|q| q.value),
            _ => None,
        }
    }

    /// Returns the text that would be typed for this value.
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

/// Named module: a MAT, a LIA, a port or a generator.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Section, e.g. `MAS`.
    pub kind: String,
    /// Place of the kind.
    pub kind_span: Span,
    /// Full name; in a group it begins with the name of the group and a dot.
    pub name: String,
    /// Place of the name.
    pub name_span: Span,
    /// Index into [`Model::groups`], for members of a group.
    pub group: Option<usize>,
    /// Parameters as written, in order.
    pub args: Vec<Entry>,
    /// Place of the whole value.
    pub span: Span,
}

/// Lower-case table: modules that share a medium, a dimension and other properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Name of the group.
    pub name: String,
    /// Place of the name.
    pub span: Span,
    /// Properties, e.g. `gravity`.
    pub props: Vec<Entry>,
}

/// Model as its author wrote it. Root tables stay entries; the compiler gives them meaning.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// File name for reports; may be empty.
    pub file: String,
    /// Source text of the spans; empty for built models.
    pub text: String,
    /// Comment block at the head of the file, without its `#`.
    pub header: String,
    /// `[model]`: title, units, gravity, friction and others.
    pub meta: Vec<Entry>,
    /// `[rate]`: sound, oversample, gesture, border, latency, feedback, filter.
    pub rate: Vec<Entry>,
    /// `[param]`: name = value or { value, unit, live, min, max, doc, port, span }.
    pub params: Vec<Entry>,
    /// `[gesture]`: port or live parameter = list of [time, value].
    pub gestures: Vec<Entry>,
    /// `[preset.NAME]`: a table of live parameter = value for each preset
    pub presets: Vec<Entry>,
    /// `[equivalence]`: quantity = [real, simulated].
    pub equivalence: Vec<Entry>,
    /// `[part.NAME]`: reusable pieces, as written.
    pub parts: Vec<Part>,
    /// `[use]`: instances of parts, as written; their modules are in `items`.
    pub uses: Vec<Use>,
    /// Other files that parts were taken from.
    pub files: Vec<SourceFile>,
    /// Groups in document order.
    pub groups: Vec<Group>,
    /// Modules in document order.
    pub items: Vec<Item>,
    /// Names in the text whose place or form is wrong. This was reported, so references to them are not reported again.
    pub lost: Vec<String>,
}

impl Model {
    /// Adds a module, for models built by programs. `name` must be unique (the compiler reports duplicates).
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

    /// Sets a parameter from text, as `--set` does: `hammer.m` of a module, or the name of a `[param]`.
    ///
    /// Numbers and quantities are read as such, `true` and `false` as flags, anything else as text. The compiler checks
    /// them as usual, but findings lack a place, since the value is not in the text. Returns false for an unknown name.
    pub fn set(&mut self, name: &str, text: &str) -> bool {
        self.put(name, Value::typed(text))
    }

    /// Sets a parameter as [`Model::set`] does, to any value.
    pub fn put(&mut self, name: &str, value: Value) -> bool {
        if let Some(e) = self.params.iter_mut().find(|e| e.key == name) {
            e.set_value(value, Span::NONE);
            return true;
        }
        if name == PRESET {
            return self.choose(&value.shown());
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

    /// Gives live parameters the values of a preset. Returns false if the model lacks the preset.
    fn choose(&mut self, preset: &str) -> bool {
        let Some(Value::Table(values)) = self.presets.iter().find(|e| e.key == preset).map(|e| e.value.clone()) else {
            return false;
        };
        for e in values {
            // the compiler reports a name that does not exist
            self.put(&e.key, e.value);
        }
        true
    }

    /// Returns the entry `key` of `[model]`, if written.
    pub fn meta(&self, key: &str) -> Option<&Entry> {
        self.meta.iter().find(|e| e.key == key)
    }

    /// Returns the `title` of `[model]`, or an empty string.
    pub fn title(&self) -> &str {
        match self.meta("title").map(|e| &e.value) {
            Some(Value::Text(t)) => t,
            _ => "",
        }
    }
}

/// Splits the key of a value in a list: `f[1]` → `f` and 1.
pub fn in_list(key: &str) -> (&str, Option<usize>) {
    match key.strip_suffix(']').and_then(|k| k.split_once('[')) {
        Some((whole, at)) => at.parse().map_or((key, None), |at| (whole, Some(at))),
        None => (key, None),
    }
}

/// Adds the unit of a parameter to a bare number, which is in SI units: the range of the parameter has a unit, too.
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

/// `[part.NAME]` as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name of the part.
    pub name: String,
    /// Place of the name.
    pub span: Span,
    /// Description of one line.
    pub doc: String,
    /// Properties of the group of each instance.
    pub props: Vec<Entry>,
    /// Parameters, modules, groups, gestures and used parts.
    pub body: Model,
}

/// Line of `[use]` as written.
#[derive(Clone, Debug, PartialEq)]
pub struct Use {
    /// Name of the instance, or of all instances.
    pub name: String,
    /// Place of the name.
    pub span: Span,
    /// Name of the part; `None` for a whole file.
    pub part: Option<Entry>,
    /// File that contains it, if it is another file; the path starts from the folder of this one.
    pub file: Option<Entry>,
    /// Number of instances; without it there is one, whose modules have names without an index.
    pub n: Option<Entry>,
    /// Values of its parameters; for several instances a list has one value for each.
    pub with: Vec<Entry>,
}

impl Use {
    /// Makes one instance `name` of a part that is given separately.
    pub fn new(name: &str) -> Use {
        Use { name: name.into(), span: Span::NONE, part: None, file: None, n: None, with: Vec::new() }
    }
}

/// File that a model takes parts from.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    /// Path from the folder of the model.
    pub name: String,
    /// Text of the file.
    pub text: String,
    /// Offset of its first byte among all spans of the model.
    pub start: usize,
}
