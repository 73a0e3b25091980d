//! Finds the number of the text that tunes a module of an instance: the argument that `[use]` passes to a parameter. A
//! number of a part that several instances share is not changed, since it would tune them all.

use super::Variable;
use ca_edit::Place;
use ca_lab::Failure;
use ca_model::part::Use;
use ca_model::{Item, Model, Value, quantity};

/// Returns the variable of a module of an instance; `None` for any other module.
pub(super) fn variable(
    model: &Model,
    item: &Item,
    entry: Option<&Value>,
    (key, unit, slope): (&'static str, &'static str, f64),
) -> Option<Result<Variable, Failure>> {
    let (u, index, rest) = model.uses.iter().find_map(|u| of(u, &item.name))?;
    let refuse = |what: String| Some(Err(Failure::Usage(format!("`{}`: {what}", item.name))));
    if rest.contains(['[', '.']) {
        return refuse("it belongs to an instance inside an instance; tune it with their parameters".into());
    }
    let prefix = index.map_or(format!("{}.", u.name), |i| format!("{}[{i}].", u.name));
    // the first number of a bank is its pitch
    let (entry, listed) = match entry {
        Some(Value::List(all)) => (all.first().map(|e| &e.value), true),
        other => (other, false),
    };
    let text = if let Some(Value::Text(t)) = entry { Some(t.as_str()) } else { None };
    let param = text.and_then(|name| name.strip_prefix(&prefix));
    let made = |place: Place, index| {
        Some(Ok(Variable { part: item.name.clone(), cell: None, place: Place { index, ..place }, unit, slope }))
    };
    if let Some(name) = param {
        match u.with.iter().find(|e| e.key == name).map(|e| &e.value) {
            Some(Value::List(_)) if index.is_some() => return made(Place::keys(["use", &u.name, "with", name]), index),
            Some(_) if index.is_none() => return made(Place::keys(["use", &u.name, "with", name]), None),
            Some(_) => {
                let n = "a list with one value for each";
                return refuse(format!("all instances of `{}` share one `{name}`; write {n} in `with`", u.name));
            }
            None => {}
        }
    }
    if let Some((_, name)) = text.and_then(quantity::product) {
        return refuse(format!(
            "its `{key}` is a multiple of `{name}`, which other pitches follow; tune one of those instead"
        ));
    }
    if listed && param.is_none() {
        let what =
            "is a list in the part, shared by all instances; make its first number a parameter and set it in `with`";
        return refuse(format!("its `{key}` {what}"));
    }
    let part = u.part.as_ref().map(|e| &e.value);
    match (part, index) {
        (Some(Value::Text(part)), None) if u.file.is_none() => match param {
            Some(name) => {
                let p = model.parts.iter().find(|p| p.name == *part)?.body.params.iter().find(|p| p.key == name)?;
                made(Place::param(Place::keys(["part", part]), name, &p.value), None)
            }
            None => made(Place::keys(["part", part, &item.kind, rest, key]), None),
        },
        _ => refuse(match param {
            Some(name) => {
                format!("its `{key}` is `{name}` of the part, shared by all instances; set it for each in `with`")
            }
            None => {
                format!(
                    "its `{key}` is a number in the part, shared by all instances; make it a parameter and set it in `with`"
                )
            }
        }),
    }
}

/// Returns the index of the instance of `u` to which a module belongs, and its name there.
fn of<'m>(u: &'m Use, name: &'m str) -> Option<(&'m Use, Option<usize>, &'m str)> {
    let rest = name.strip_prefix(u.name.as_str())?;
    if let Some(rest) = rest.strip_prefix('.') {
        return Some((u, None, rest));
    }
    let (index, rest) = rest.strip_prefix('[')?.split_once("].")?;
    Some((u, Some(index.parse().ok()?), rest))
}
