//! Reads a sweep from a text file, `*.sweep.toml`.
//!
//! ```toml
//! model = "plucked_string"              # a file, or a bundled model
//! seconds = 0.5
//! runs = 200                            # drawn; without, every combination of values
//! seed = 1
//! audio = "flac"                        # or "wav", "none"
//!
//! [set]                                 # the same for all
//! "model.title" = "plucked"
//!
//! [vary]
//! "low.k" = { from = "1 kN/m", to = "9 kN/m", log = true }
//! "low.n" = [10, 20, 40]
//! ```
//!
//! Files are looked up beside the plan. Errors name the line.

use super::{Audio, Axis, MOST, Sweep, SweepSpec, counted, folder, measured_so, varied};
use ca_compile::Options;
use ca_core::{ABOVE_ZERO, Unit};
use ca_lab::load::{self, stem};
use ca_lab::{Failure, Found};
use ca_model::diag::Diags;
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Span, Value, quantity};
use ca_take::gesture;
use std::path::{Path, PathBuf};
use toml_edit::{Document, Item, TableLike};

const KEYS: [&str; 14] = [
    "model",
    "seconds",
    "rate",
    "gesture",
    "gesture_rate",
    "runs",
    "seed",
    "energy",
    "measure",
    "audio",
    "chunk",
    "folder",
    "set",
    "vary",
];

/// Sweep with its output.
pub struct SweepPlan {
    /// The sweep.
    pub sweep: Sweep,
    /// Format of sound files.
    pub audio: Audio,
    /// Runs per chunk.
    pub chunk: u64,
    /// Output folder: as written, or named after the plan and beside it.
    pub folder: PathBuf,
}

struct Text<'a> {
    text: &'a str,
    file: &'a str,
}

impl Text<'_> {
    fn line(&self, at: Option<std::ops::Range<usize>>) -> Option<usize> {
        at.map(|at| 1 + self.text[..at.start.min(self.text.len())].matches('\n').count())
    }

    fn wrong(&self, at: Option<std::ops::Range<usize>>, what: &str) -> Failure {
        let line = self.line(at).map_or_else(String::new, |n| format!(":{n}"));
        Failure::Usage(format!("{}{line}: {what}", self.file))
    }

    /// Adds the line to a usage error.
    fn at<T>(&self, item: &Item, done: Result<T, Failure>) -> Result<T, Failure> {
        done.map_err(|e| match e {
            Failure::Usage(what) => self.wrong(item.span(), &what),
            other => other,
        })
    }

    fn found(&self, diags: Diags) -> Failure {
        let model = Model { file: self.file.into(), text: self.text.into(), ..Model::default() };
        Failure::Found(Box::new(Found { model, diags }))
    }

    /// Moves findings about a value in the model to its place in the plan.
    fn placed<T>(&self, item: Option<&Item>, done: Result<T, Failure>) -> Result<T, Failure> {
        done.map_err(|e| {
            let Failure::Found(mut found) = e else { return e };
            for d in &mut found.diags.list {
                let label = d.labels.first().map(|l| l.1.clone()).unwrap_or_default();
                (d.labels, d.fix) = (vec![(span(item.and_then(Item::span)), label)], None);
            }
            self.found(found.diags)
        })
    }

    /// Reads a number above 0 in this unit, as in a model.
    fn number(&self, table: &dyn TableLike, key: &str, unit: Unit, what: &str) -> Result<Option<f64>, Failure> {
        let Some(item) = table.get(key) else { return Ok(None) };
        let value = item.as_value().and_then(value);
        let value = value.filter(|v| !matches!(v, Value::Text(t) if !quantity::is_quantity(t)));
        let value =
            value.ok_or_else(|| self.wrong(item.span(), &format!("`{key}` must be a number of {what} above 0")))?;
        let entry = Entry { span: span(item.span()), ..Entry::new(key, value) };
        let read = ca_compile::measured(&entry, unit, ABOVE_ZERO, &format!("`{key}`"));
        read.map(Some).map_err(|diags| self.found(diags))
    }

    /// Error for a name with a dot outside quotes, which TOML reads as a nested table.
    fn unquoted(&self, name: &str, item: &Item) -> Failure {
        let (mut whole, mut inner) = (name.to_owned(), item);
        while let Some((key, next)) = inner.as_table().and_then(|t| t.iter().next()) {
            whole = format!("{whole}.{key}");
            inner = next;
        }
        self.wrong(item.span().or(inner.span()), &format!("a name with a dot needs quotes: write `\"{whole}\" = …`"))
    }

    fn one<T>(
        &self,
        table: &dyn TableLike,
        key: &str,
        what: &str,
        read: impl Fn(&Item) -> Option<T>,
    ) -> Result<Option<T>, Failure> {
        let Some(item) = table.get(key) else { return Ok(None) };
        read(item).map(Some).ok_or_else(|| self.wrong(item.span(), &format!("`{key}` must be {what}")))
    }

    fn known(&self, table: &dyn TableLike, keys: &[&str]) -> Result<(), Failure> {
        let Some((wrong, item)) = table.iter().find(|(k, _)| !keys.contains(k)) else { return Ok(()) };
        let at = table.key(wrong).and_then(toml_edit::Key::span).or(item.span());
        let hint = nearest(wrong, keys.iter().copied())
            .map_or_else(|| format!("use {}", load::ticked(keys.iter().copied())), |m| format!("did you mean `{m}`?"));
        Err(self.wrong(at, &format!("unknown key `{wrong}`; {hint}")))
    }
}

fn span(at: Option<std::ops::Range<usize>>) -> Span {
    at.map_or(Span::NONE, |at| Span { start: at.start, end: at.end })
}

fn whole(item: &Item) -> Option<u64> {
    item.as_integer().and_then(|v| u64::try_from(v).ok())
}

fn value(item: &toml_edit::Value) -> Option<Value> {
    use toml_edit::Value as V;
    Some(match item {
        V::String(t) => Value::Text(t.value().clone()),
        V::Integer(v) => Value::Num(*v.value() as f64),
        V::Float(v) => Value::Num(*v.value()),
        V::Boolean(v) => Value::Bool(*v.value()),
        V::Array(list) => Value::List(list.iter().map(|v| Some(Entry::new("", value(v)?))).collect::<Option<_>>()?),
        V::InlineTable(t) => {
            Value::Table(t.iter().map(|(k, v)| Some(Entry::new(k, value(v)?))).collect::<Option<_>>()?)
        }
        V::Datetime(_) => return None,
    })
}

/// Reads a plan.
///
/// # Errors
/// [`Failure::Failed`] if the file cannot be read; [`Failure::Usage`] with the line of an error; and as [`Sweep::new`].
pub fn read(path: &Path) -> Result<SweepPlan, Failure> {
    let text = load::text(path)?;
    let file = path.display().to_string();
    let t = Text { text: &text, file: &file };
    let doc = Document::parse(text.as_str()).map_err(|e| t.wrong(e.span(), e.message()))?;
    let top = doc.as_table();
    t.known(top, &KEYS)?;
    let beside = path.parent().unwrap_or(Path::new(""));
    let text_of = |item: &Item| item.as_str().map(str::to_owned);

    let model = t.one(top, "model", "the name of a model, in quotes", text_of)?;
    let model = model.ok_or_else(|| t.wrong(None, "`model` is missing; name the model to sweep"))?;
    let near = beside.join(&model);
    let word = if near.is_file() { near.display().to_string() } else { model };
    let mut loaded = t.at(&top["model"], load::load(&word))?;
    let table = |key: &str| -> Result<Option<&dyn TableLike>, Failure> {
        let Some(item) = top.get(key) else { return Ok(None) };
        item.as_table_like()
            .map(Some)
            .ok_or_else(|| t.wrong(item.span(), &format!("`{key}` must be a section, `[{key}]`")))
    };
    let (set, vary) = (table("set")?, table("vary")?);
    let both = set
        .into_iter()
        .flat_map(TableLike::iter)
        .find(|(name, item)| !item.is_table() && vary.is_some_and(|v| v.contains_key(name)));
    if let Some((name, item)) = both {
        let varied = vary.and_then(|v| t.line(v.get(name)?.span())).unwrap_or_default();
        let what = format!("`{name}` is set here and varied in line {varied}; remove one of them");
        return Err(t.wrong(item.span(), &what));
    }
    for (name, item) in set.map(TableLike::iter).into_iter().flatten() {
        if item.is_table() {
            return Err(t.unquoted(name, item));
        }
        let value = item.as_value().and_then(value);
        let value = value.ok_or_else(|| {
            t.wrong(item.span(), &format!("`{name}` must be a number, text, a flag, a list or a table"))
        })?;
        t.at(item, t.placed(Some(item), measured_so(&loaded, name, &value)))?;
        t.at(item, load::set(&mut loaded, name, value))?;
    }
    let vary = vary.ok_or_else(|| t.wrong(None, "`[vary]` is missing; name the parameters to vary there"))?;
    let runs = t.one(top, "runs", &format!("a whole number from 1 to {MOST}"), |i| {
        whole(i).filter(|n| (1..=MOST).contains(n))
    })?;
    let mut axes = Vec::new();
    for (name, item) in vary.iter() {
        let axis = axis(&t, name, item)?;
        t.at(item, varied(&axis))?;
        t.at(item, load::set(&mut loaded.clone(), &axis.name, axis.at(0.0)))?;
        for (key, end) in ["from", "to"].iter().zip(axis.ends.iter().flatten()) {
            t.placed(item.get(key), measured_so(&loaded, &axis.name, end))?;
        }
        if runs.is_none() {
            t.at(item, counted(&axis))?;
        }
        axes.push(axis);
    }
    let yes = |key: &str, or: bool| t.one(top, key, "`true` or `false`", Item::as_bool).map(|v| v.unwrap_or(or));
    let ask = SweepSpec {
        axes,
        runs,
        seed: t.one(top, "seed", "a whole number of at least 0", whole)?.unwrap_or(0),
        seconds: t.number(top, "seconds", Unit::SECOND, "seconds")?,
        rate: t.number(top, "rate", Unit::HERTZ, "hertz")?,
        energy: yes("energy", false)?,
        measure: yes("measure", true)?,
    };
    let files =
        t.one(top, "gesture", "a file, or a list of files, e.g. \"key=take.wav\"", |item| match item.as_array() {
            Some(list) => list.iter().map(|v| v.as_str().map(str::to_owned)).collect(),
            None => text_of(item).map(|f| vec![f]),
        })?;
    let gesture_rate = t.number(top, "gesture_rate", Unit::HERTZ, "hertz")?;
    let gesture = match files {
        Some(files) => {
            let scene = loaded.compile(&Options { rate: ask.rate, ..Options::default() })?;
            gesture::open(&files, gesture_rate, &scene, beside, &mut |_| {})?
        }
        None => None,
    };
    let audio = t.one(top, "audio", "\"flac\", \"wav\" or \"none\"", |i| i.as_str().and_then(Audio::named))?;
    let chunk = t.one(top, "chunk", "a whole number of at least 1", |i| whole(i).filter(|n| *n > 0))?;
    let home = t.one(top, "folder", "the name of a folder, in quotes", text_of)?;
    let own = stem(path);
    let own = own.strip_suffix(".sweep").unwrap_or(&own);
    let sweep = Sweep::new(loaded, ask, gesture)?;
    Ok(SweepPlan {
        audio: audio.unwrap_or(Audio::Flac),
        chunk: chunk.unwrap_or(folder::chunk(sweep.runs())),
        sweep,
        folder: beside.join(home.as_deref().unwrap_or(own)),
    })
}

fn axis(t: &Text, name: &str, item: &Item) -> Result<Axis, Failure> {
    if let Some(list) = item.as_array() {
        let values = list.iter().map(value).collect::<Option<Vec<_>>>();
        let values = values.ok_or_else(|| {
            t.wrong(item.span(), &format!("`{name}` contains a date; use numbers, quantities or text"))
        })?;
        return t.at(item, Axis::list(name, values));
    }
    let what = format!("`{name}` must be a list of values, or `{{ from = …, to = … }}`");
    let range = item.as_table_like().ok_or_else(|| t.wrong(item.span(), &what))?;
    if item.is_table() && range.get("from").or(range.get("to")).is_none() {
        return Err(t.unquoted(name, item));
    }
    t.known(range, &["from", "to", "steps", "log"])?;
    let end = |key: &str| t.one(range, key, "a number or a quantity", |i| i.as_value().and_then(value));
    let (Some(from), Some(to)) = (end("from")?, end("to")?) else { return Err(t.wrong(item.span(), &what)) };
    let log = t.one(range, "log", "`true` or `false`", Item::as_bool)?.unwrap_or(false);
    let steps = t.one(range, "steps", "a whole number of at least 2", whole)?;
    t.at(item, Axis::range(name, [from, to], log, steps))
}
