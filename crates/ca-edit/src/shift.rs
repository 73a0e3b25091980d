//! Moves a module: sets its rest position `x`.

use crate::symbols::{Class, Symbol, Want, Written};
use crate::value::{finish, shown};
use crate::{Edited, Place, Refusal, Value, number};
use ca_core::{Type, Unit};
use ca_model::quantity::{rounded, show};

/// Digits of a written position.
const DIGITS: usize = 6;

/// Moves the module `name` to a position \[m\]: one number on a line, two or three in space.
pub(crate) fn shift(w: &Written, name: &str, to: &[f64]) -> Result<Edited, Refusal> {
    let symbol = w.find(name)?;
    let item = w.body(symbol.scope).items.get(symbol.index).filter(|_| symbol.class == Class::Module);
    let kind = item.and_then(|i| w.catalog.get(&i.kind));
    let has_place =
        kind.is_some_and(|k| k.params.iter().any(|p| p.name == "x" && matches!(p.ty, Type::Position { .. })));
    if !has_place {
        let help = "move a mass, a fixed point, a port or a generator; a link is drawn between its ends";
        return Err(Refusal::new(format!("`{}` cannot move", shown(name)), help));
    }
    let dim = dim(w, symbol);
    if to.len() != dim || !to.iter().all(|v| v.is_finite()) {
        let what = format!("`{}` needs {dim} finite coordinate{}", shown(name), if dim == 1 { "" } else { "s" });
        return Err(Refusal::new(what, "give one for each axis, in metres"));
    }
    let place = Place::keys(w.path(symbol)).then("x");
    let mut document = w.document.clone();
    let old = document.value(&place);
    let follows = |v: &Value| matches!(v, Value::Text(t) if !w.hits(symbol.scope, t, Want::Number).is_empty());
    let all: &[Value] = if let Some(Value::List(all)) = &old { all } else { old.as_slice() };
    if all.iter().any(follows) {
        return Err(Refusal::new(format!("`x` of `{}` follows a parameter", shown(name)), "change the parameter"));
    }
    let written = |v: f64| show(rounded(v, DIGITS), Unit::METRE);
    let done = match &old {
        Some(Value::List(list)) if list.len() == dim => to.iter().enumerate().try_for_each(|(i, v)| {
            let one = Place { index: Some(i), ..place.clone() };
            number::write(&mut document, &one, *v, "", DIGITS).map(|_| ())
        }),
        Some(Value::Text(_) | Value::Number(_)) if dim == 1 => {
            number::write(&mut document, &place, to[0], "m", DIGITS).map(|_| ())
        }
        _ if dim == 1 => document.insert(&place, &Value::Text(written(to[0]))),
        _ => document.insert(&place, &Value::List(to.iter().map(|v| Value::Text(written(*v))).collect())),
    };
    finish(w, done.map(|()| document), name)
}

/// Returns the number of axes of a module.
fn dim(w: &Written, symbol: Symbol) -> usize {
    let body = w.body(symbol.scope);
    let group = body.items[symbol.index].group.and_then(|g| body.groups.get(g)).map(|g| &g.props);
    let part = symbol.scope.and_then(|p| w.model.parts.get(p)).map(|p| &p.props);
    let of = |props: Option<&Vec<ca_model::Entry>>| {
        let e = props.and_then(|p| p.iter().find(|e| e.key == "dim"))?;
        e.value.number().filter(|v| (1.0..=3.0).contains(v)).map(|v| v as usize)
    };
    of(group).or_else(|| of(part)).unwrap_or(1)
}
