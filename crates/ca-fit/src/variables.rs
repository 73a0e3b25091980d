//! Numbers of a model that are varied: their start and their range.
//!
//! A number that cannot be negative is varied by its logarithm: steps are then ratios, a step cannot leave the valid
//! range, and an uncertainty is a fraction of the value. Other numbers are scaled by half the width of their range, or
//! by their start. A number that follows a `[param]` is refused with the name of that `[param]`, since varying it alone
//! would break the relation that the author wrote.

use super::verdict::Words;
use ca_compile::Options;
use ca_core::{Need, Param, Type};
use ca_lab::{Failure, catalog, load};
use ca_model::part::instances;
use ca_model::quantity::{self, Plain, six, unit_of};
use ca_model::{Entry, Model, Value};
use cordis_anima::Loaded;

/// Range of a number, as the user wrote it.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Name in the syntax of `--set`.
    pub name: String,
    /// Lower and upper end.
    pub ends: [Value; 2],
}

/// Number that is varied.
#[derive(Clone, Debug, PartialEq)]
pub struct Varied {
    /// Name in the syntax of `--set`.
    pub name: String,
    /// Unit; empty for a plain number.
    pub unit: String,
    /// Initial value.
    pub start: f64,
    /// Least and greatest value.
    pub bounds: [f64; 2],
    /// True if it is varied by its logarithm.
    pub log: bool,
}

struct Written {
    value: f64,
    unit: String,
}

impl Varied {
    /// Finds the number of this name, within the range of its kind and the requested one.
    ///
    /// # Errors
    /// [`Failure::Usage`] where it does not exist, is not a number, follows another or starts outside its range.
    pub fn of(loaded: &Loaded, name: &str, ranges: &[Range], words: &Words) -> Result<Varied, Failure> {
        let model = &loaded.model;
        let first = match instances(model, name) {
            Some(each) => each.into_iter().next().unwrap_or_else(|| name.to_owned()),
            None => name.to_owned(),
        };
        // reports a missing name, with a suggestion
        load::set(&mut loaded.clone(), &first, Value::Num(1.0))?;
        // a bare end of the range is in the unit beside the value of a `[param]`
        let (written, own, size) = match model.params.iter().find(|e| e.key == first) {
            Some(e) => param(e)?,
            None => argument(model, &first, words).map(|(written, own)| (written, own, 1.0))?,
        };
        let mut bounds = own;
        if let Some(range) = ranges.iter().find(|r| r.name == name) {
            range.ends.iter().try_for_each(|end| measured_so(loaded, &first, end))?;
            let end = |v: &Value| v.number().map(|n| if matches!(v, Value::Num(_)) { n * size } else { n });
            let [Some(from), Some(to)] = [end(&range.ends[0]), end(&range.ends[1])] else {
                return Err(Failure::Usage(format!("both ends of the range of `{name}` must be numbers")));
            };
            if from >= to || from.is_nan() || to.is_nan() {
                return Err(Failure::Usage(format!(
                    "the range of `{name}` is {from} to {to}; put the smaller end first"
                )));
            }
            bounds = [bounds[0].max(from), bounds[1].min(to)];
        }
        let Written { value: start, unit } = written;
        let log = bounds[0] >= 0.0 && start > 0.0;
        let found = Varied { name: name.to_owned(), unit, start, bounds, log };
        if !(bounds[0]..=bounds[1]).contains(&start) {
            let [from, to] = bounds.map(|v| found.shown(v));
            let what = format!("`{name}` starts at {}, outside its range {from} to {to}", found.shown(start));
            return Err(Failure::Usage(format!(
                "{what}; start it at another value with {}, or widen its range",
                words.set
            )));
        }
        if start == 0.0 && !(bounds[1] - bounds[0]).is_finite() {
            let what = format!("`{name}` starts at 0 without a finite range, so the size of a step is unknown");
            return Err(Failure::Usage(format!("{what}; give it another start with {}, or a range", words.set)));
        }
        Ok(found)
    }

    /// Size of one unit of the search coordinate, if it is not logarithmic.
    fn scale(&self) -> f64 {
        let width = 0.5 * (self.bounds[1] - self.bounds[0]);
        if width.is_finite() && width < 1e150 { width } else { self.start.abs() }
    }

    /// Search coordinate of a value.
    pub fn place(&self, value: f64) -> f64 {
        if self.log { libm::log(value / self.start) } else { (value - self.start) / self.scale() }
    }

    /// Value at a search coordinate.
    pub fn value(&self, place: f64) -> f64 {
        let v = if self.log { self.start * libm::exp(place) } else { self.start + place * self.scale() };
        v.clamp(self.bounds[0], self.bounds[1])
    }

    /// Bounds of the search coordinate.
    pub fn ends(&self) -> [f64; 2] {
        self.bounds.map(|v| {
            let place = self.place(v);
            if place.is_nan() { 0.0 } else { place }
        })
    }

    /// Converts a standard deviation of the search coordinate to the unit of the number.
    pub fn deviation(&self, value: f64, place: f64) -> f64 {
        if self.log { value * place } else { place * self.scale() }
    }

    /// Value as it is set in the model.
    pub fn setting(&self, value: f64) -> Value {
        if self.unit.is_empty() { Value::Num(value) } else { Value::Text(format!("{value:e} {}", self.unit)) }
    }

    /// Value as a user would write it, with six digits.
    pub fn shown(&self, value: f64) -> String {
        format!("{} {}", Plain(six(value)), self.unit).trim_end().to_owned()
    }
}

/// Reads a value as a number, or returns the reason why it is not one.
fn plain(name: &str, value: &Value, params: &[Entry]) -> Result<Written, Failure> {
    let no = |what: String| Err(Failure::Usage(format!("`{name}` {what}")));
    match value {
        Value::Num(v) => Ok(Written { value: *v, unit: String::new() }),
        Value::Text(t) => {
            let follows = quantity::product(t).map_or(t.trim(), |(_, of)| of);
            if params.iter().any(|e| e.key == follows) {
                return no(format!("follows the parameter `{follows}`; vary `{follows}` instead"));
            }
            if let Some(f) = quantity::note(t) {
                return Ok(Written { value: f, unit: "Hz".into() });
            }
            match quantity::parse(t) {
                Ok(q) => Ok(Written { value: q.value, unit: if q.has_unit { unit_of(q.dim) } else { String::new() } }),
                Err(_) => no(format!("is `{}`, which is not a number", t.trim())),
            }
        }
        _ => no("is not a single number".into()),
    }
}

/// Refuses an end of a range whose unit has another dimension, with the message for setting it.
fn measured_so(loaded: &Loaded, name: &str, end: &Value) -> Result<(), Failure> {
    // a bare number has the unit of the number that it limits
    if matches!(end, Value::Num(_)) {
        return Ok(());
    }
    let mut model = loaded.clone();
    load::set(&mut model, name, end.clone())?;
    let options = Options { clouds: loaded.clouds.clone(), ..Options::default() };
    let Err(mut found) = model.compile(&options) else { return Ok(()) };
    found.diags.list.retain(|d| d.code == "E008");
    // errors of the model itself are reported by the fit
    let by_it = !found.diags.list.is_empty() && loaded.compile(&options).is_ok();
    if by_it { Err(Failure::Found(found)) } else { Ok(()) }
}

/// Reads a `[param]`: its number, its bounds, and the factor of a bare number.
fn param(e: &Entry) -> Result<(Written, [f64; 2], f64), Failure> {
    let Value::Table(entries) = &e.value else {
        return Ok((plain(&e.key, &e.value, &[])?, [f64::MIN, f64::MAX], 1.0));
    };
    let of = |key: &str| entries.iter().find(|x| x.key == key).map(|x| &x.value);
    if of("port").is_some() {
        return Err(Failure::Usage(format!(
            "`{}` is driven by a port, so it cannot be varied; set it with a gesture",
            e.key
        )));
    }
    // a bare number has the unit written beside it
    let unit = match of("unit") {
        Some(Value::Text(u)) if !u.is_empty() => quantity::parse(&format!("1 {u}")).ok(),
        _ => None,
    };
    let read = |value: &Value| -> Result<Written, Failure> {
        let read = plain(&e.key, value, &[])?;
        Ok(match (&unit, read.unit.is_empty()) {
            (Some(q), true) => Written { value: read.value * q.value, unit: unit_of(q.dim) },
            _ => read,
        })
    };
    let Some(value) = of("value") else {
        return Err(Failure::Usage(format!("the parameter `{}` has no `value`; add one", e.key)));
    };
    let end = |key: &str, without: f64| of(key).map_or(Ok(without), |v| read(v).map(|w| w.value));
    Ok((read(value)?, [end("min", f64::MIN)?, end("max", f64::MAX)?], unit.as_ref().map_or(1.0, |q| q.value)))
}

/// Reads a parameter of a module, with the range of its kind.
fn argument(model: &Model, name: &str, words: &Words) -> Result<(Written, [f64; 2]), Failure> {
    let usage = |what: String| Failure::Usage(what);
    let found = name.rsplit_once('.').and_then(|(owner, key)| {
        let item = model.items.iter().find(|i| i.name == owner)?;
        let kind = catalog().get(&item.kind)?;
        Some((item, key, kind.params.iter().find(|p| p.name == key)?))
    });
    let Some((item, key, known)) = found else {
        return Err(usage(format!("`{name}` is not a number of a module or `[param]`, so it cannot be varied")));
    };
    let Some((bounds, symbol)) = range(known) else {
        return Err(usage(format!("`{name}` is not a single number, so it cannot be varied")));
    };
    if let Some(e) = item.args.iter().find(|e| e.key == key) {
        let read = plain(name, &e.value, &model.params)?;
        // a bare number has the unit of its parameter
        let unit = if read.unit.is_empty() { symbol.to_owned() } else { read.unit };
        return Ok((Written { unit, ..read }, bounds));
    }
    if let Need::Default(value) = known.need {
        return Ok((Written { value, unit: symbol.into() }, bounds));
    }
    let what = format!("`{name}` has no value in the model to start from");
    Err(usage(format!("{what}; give it a start with {}", words.set)))
}

fn range(known: &Param) -> Option<([f64; 2], &'static str)> {
    match known.ty {
        Type::Number { unit, min, max } | Type::Numbers { unit, min, max } => Some(([min, max], unit.symbol)),
        Type::PowerStiffness { .. } => Some(([0.0, f64::MAX], "")),
        // a position is one number on a line; in space it is a list, which is refused later
        Type::Position { unit } => Some(([f64::MIN, f64::MAX], unit.symbol)),
        _ => None,
    }
}
