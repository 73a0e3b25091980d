//! Parameters: resolves a name in the syntax of `--set` to the number written there, and writes another value into the
//! model.
//!
//! A quantity is varied in SI units, a bare number in the units of the model, which are SI unless the model says
//! otherwise. One number of a list is a parameter too (`ball.v[1]`), since positions and speeds in space are lists. If
//! a value is the name of a `[param]`, or a multiple of one, only that value is varied; the name of the `[param]`
//! itself varies all its uses.

use crate::Error;
use ca_core::{Catalog, Kind, Need, Param, Type, Unit};
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Value, quantity};

/// Parameter to differentiate by.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name as requested.
    pub name: String,
    /// Value, in `unit`.
    pub value: f64,
    /// SI unit; empty for a plain number and for a bare one, which is in the units of the model.
    pub unit: String,
}

impl Parameter {
    pub(crate) fn find(model: &Model, catalog: &Catalog, name: &str) -> Result<Parameter, Error> {
        let (whole, index) = split(name);
        let Some((e, unit)) = place(model, catalog, name, whole)? else { return absent(model, catalog, name, whole) };
        let value = match (index, &e.value) {
            (None, value) => value,
            (Some(i), Value::List(list)) => {
                let Some(e) = list.get(i) else {
                    return Err(Error::refused(format!(
                        "`{name}` does not exist: the list has {} numbers, counted from 0",
                        list.len()
                    )));
                };
                &e.value
            }
            (Some(_), _) => return Err(Error::refused(format!("`{name}`: `{whole}` is not a list"))),
        };
        if matches!(value, Value::List(_)) && index.is_some() {
            return Err(Error::refused(format!(
                "`{name}` is a list inside a list; there are no derivatives by its numbers"
            )));
        }
        if matches!(value, Value::List(_)) {
            return Err(Error::refused(format!("`{name}` is a list; name one of its numbers, e.g. `{name}[0]`")));
        }
        let (value, unit) =
            number(model, value, unit).ok_or_else(|| Error::refused(format!("`{name}` is not a number")))?;
        Ok(Parameter { name: name.into(), value, unit })
    }
}

fn entry<'m>(model: &'m Model, name: &str) -> Option<&'m Entry> {
    if let Some(e) = model.params.iter().find(|e| e.key == name) {
        return Some(e);
    }
    let (owner, key) = name.rsplit_once('.')?;
    let args = match owner {
        "model" => &model.meta,
        "rate" => &model.rate,
        _ => &model.items.iter().find(|i| i.name == owner)?.args,
    };
    args.iter().find(|e| e.key == key)
}

/// Returns the model with a parameter at `value`.
pub(crate) fn put(p: &Parameter, model: &Model, value: f64) -> Model {
    let mut other = model.clone();
    let unit = &p.unit;
    let written = if unit.is_empty() { Value::Num(value) } else { format!("{value:e} {unit}").into() };
    let (whole, index) = split(&p.name);
    let list = index.and_then(|i| match entry(model, whole).map(|e| &e.value) {
        Some(Value::List(list)) => Some((i, list.clone())),
        _ => None,
    });
    let to = match list {
        Some((i, mut list)) => {
            list[i] = Entry::new("", written);
            Value::List(list)
        }
        None => written,
    };
    other.put(whole, to);
    other
}

/// Splits `ball.v[1]` into `ball.v` and 1.
fn split(name: &str) -> (&str, Option<usize>) {
    let parts = name.strip_suffix(']').and_then(|n| n.rsplit_once('['));
    match parts.and_then(|(whole, i)| Some((whole, i.parse().ok()?))) {
        Some((whole, i)) if entry_like(whole) => (whole, Some(i)),
        _ => (name, None),
    }
}

/// Returns whether an index after `whole` selects from a list: in `key[2]` it selects an instance.
fn entry_like(whole: &str) -> bool {
    whole.rsplit_once('.').is_some_and(|(_, key)| !key.contains(']'))
}

/// Returns the kind of a module and, if it exists, the named parameter of that kind.
fn param<'c>(model: &Model, catalog: &'c Catalog, name: &str) -> Option<(&'c Kind, Option<&'c Param>)> {
    let (owner, key) = name.rsplit_once('.')?;
    let item = model.items.iter().find(|i| i.name == owner)?;
    let kind = catalog.get(&item.kind)?;
    Some((kind, kind.param(key).map(|i| &kind.params[i])))
}

/// Returns the entry at the parameter `whole` with its unit, if known; `None` where the model does not write it.
fn place<'m>(
    model: &'m Model,
    catalog: &Catalog,
    name: &str,
    whole: &str,
) -> Result<Option<(&'m Entry, Option<Unit>)>, Error> {
    let e = entry(model, whole);
    let Some((kind, of_kind)) = param(model, catalog, whole) else { return Ok(e.map(|e| (e, None))) };
    let Some(param) = of_kind else {
        let near = nearest(whole.rsplit('.').next().unwrap_or(whole), kind.params.iter().map(|p| p.name));
        let hint = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        return Err(Error::refused(format!("`{name}`: `{}` has no such parameter{hint}", kind.code)));
    };
    let no = |what: &str| Err(Error::refused(format!("no derivative by `{name}`: it is {what}")));
    let exponent = |p: &Param| matches!(p.ty, Type::PowerStiffness { exponent } if exponent == param.name);
    let unit = match param.ty {
        Type::Number { .. } if kind.params.iter().any(exponent) => return no("an exponent, a multiple of 1/4"),
        Type::Number { unit, .. } | Type::Numbers { unit, .. } | Type::Position { unit } => Some(unit),
        Type::PowerStiffness { .. } | Type::Points { .. } | Type::Positions { .. } | Type::Direction => None,
        Type::Count { .. } | Type::Counts { .. } => return no("a whole number"),
        Type::Choice(_) => return no("one of several words"),
        Type::Flag => return no("a flag"),
        Type::Between | Type::Nodes | Type::Module | Type::File | Type::Text | Type::Midi => return no("not a number"),
    };
    Ok(e.map(|e| (e, unit)))
}

/// Handles a parameter that the model does not write: returns its default, or the reason why there is none to vary.
fn absent(model: &Model, catalog: &Catalog, name: &str, whole: &str) -> Result<Parameter, Error> {
    if let Some((_, Some(param))) = param(model, catalog, whole) {
        let unit = match param.ty {
            Type::Number { unit, .. } | Type::Position { unit } => Some(unit),
            _ => None,
        };
        return match (param.need, unit) {
            (Need::Default(value), Some(unit)) if whole == name => {
                Ok(Parameter { name: name.into(), value, unit: unit.symbol.into() })
            }
            _ => Err(Error::refused(format!("`{name}` has no value in the model; give it one"))),
        };
    }
    let items = model.items.iter().flat_map(|i| {
        let keys = catalog.get(&i.kind).into_iter().flat_map(|k| k.params);
        keys.map(|p| format!("{}.{}", i.name, p.name))
    });
    let all: Vec<String> = model.params.iter().map(|e| e.key.clone()).chain(items).collect();
    let near = nearest(name, all.iter().map(String::as_str));
    let hint = near.map_or(String::new(), |n| format!("; did you mean `{n}`?"));
    Err(Error::refused(format!("the model has no `{name}`{hint}")))
}

/// Returns the number that a value stands for, and its unit, which is empty for a bare number.
fn number(model: &Model, value: &Value, unit: Option<Unit>) -> Option<(f64, String)> {
    let of_param = |name: &str| match &model.params.iter().find(|e| e.key == name)?.value {
        // a `[param]` that names another `[param]` is not followed
        Value::Text(t) if model.params.iter().any(|e| e.key == *t) => None,
        value => number(model, value, unit),
    };
    match value {
        Value::Num(v) => Some((*v, String::new())),
        Value::Text(t) => {
            if let Some(found) = of_param(t) {
                return Some(found);
            }
            if let Some((v, unit)) = quantity::product(t).and_then(|(factor, name)| {
                let (v, unit) = of_param(name)?;
                Some((factor * v, unit))
            }) {
                return Some((v, unit));
            }
            if let Some(f) = quantity::note(t).filter(|_| unit.is_none_or(|u| u.dim.same(Unit::HERTZ.dim))) {
                return Some((f, "Hz".into()));
            }
            let q = quantity::parse(t).ok()?;
            Some((q.value, if q.has_unit { quantity::unit_of(q.dim) } else { String::new() }))
        }
        Value::Table(entries) => {
            let get = |key: &str| entries.iter().find(|e| e.key == key).map(|e| &e.value);
            match (get("value")?, get("unit")) {
                (Value::Num(v), Some(Value::Text(u))) if !u.is_empty() => {
                    number(model, &Value::Text(format!("{v:e} {u}")), unit)
                }
                (value, _) => number(model, value, unit),
            }
        }
        _ => None,
    }
}
