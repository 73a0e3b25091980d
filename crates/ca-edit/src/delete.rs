//! Deletes modules, groups, instances, parameters, parts and presets, with what refers to them.

use crate::layout::quoted;
use crate::paths::Paths;
use crate::references::{Owner, Reference};
use crate::symbols::{Class, Symbol, Written};
use crate::value::shown;
use crate::{Edited, Refusal, TextEdit};
use ca_model::quantity::{self, Plain, product};
use ca_model::{Entry, Value};
use std::collections::{BTreeSet, HashMap};

/// Deletes what `names` says. If something else refers to it, this needs `dependents`: links, instances, gestures and
/// values of presets are then deleted too, and a number that names a deleted parameter gets its value.
pub(crate) fn delete(w: &Written, names: &[String], dependents: bool) -> Result<Edited, Refusal> {
    let mut gone: BTreeSet<Symbol> = BTreeSet::new();
    let mut open = Vec::new();
    for name in names {
        open.push(w.find(name)?);
    }
    let asked: BTreeSet<Symbol> = open.iter().copied().collect();
    let all = w.references();
    let mut of: HashMap<Symbol, Vec<&Reference>> = HashMap::new();
    for r in &all {
        for symbol in r.hits.iter().map(|h| h.symbol).collect::<BTreeSet<_>>() {
            of.entry(symbol).or_default().push(r);
        }
    }
    let (mut entries, mut edits, mut listed) = (BTreeSet::new(), Vec::new(), BTreeSet::new());
    let mut values: Vec<(Symbol, String)> = Vec::new();
    let mut inlined: Vec<(&Reference, Symbol)> = Vec::new();
    while let Some(symbol) = open.pop() {
        if !gone.insert(symbol) {
            continue;
        }
        open.extend(members(w, symbol));
        for r in of.get(&symbol).into_iter().flatten().copied() {
            match &r.owner {
                Owner::Entry(path) if symbol.class != Class::Param || r.is_key => {
                    entries.insert(path.clone());
                }
                // a value of the parameter, which goes with it
                Owner::Of(owner, key) if r.is_key => {
                    values.push((*owner, key.clone()));
                }
                _ if symbol.class == Class::Param => inlined.push((r, symbol)),
                Owner::Of(owner, _) => open.push(*owner),
                Owner::Entry(_) => {}
            }
        }
    }
    listed.extend(entries.iter().map(|path: &Vec<String>| path.join(".")));
    for (owner, key) in values.into_iter().filter(|v| !gone.contains(&v.0)) {
        entries.insert([w.path(owner), key.split('.').map(Into::into).collect()].concat());
        listed.insert(format!("{}.{key}", w.address(owner)));
    }
    let mut paths: Paths = gone.iter().map(|s| w.path(*s)).chain(entries).collect();
    let is_gone = |o: &Owner| match o {
        Owner::Of(s, key) => gone.contains(s) || s.scope.is_some_and(|p| gone.contains(&part(p))) || key.is_empty(),
        Owner::Entry(p) => paths.cover(p),
    };
    for (r, symbol) in inlined.into_iter().filter(|(r, _)| !is_gone(&r.owner)) {
        listed.insert(match &r.owner {
            Owner::Of(s, key) => format!("{}.{key}", w.address(*s)),
            Owner::Entry(path) => path.join("."),
        });
        edits.push(inline(w, r, symbol)?);
    }
    let own: BTreeSet<Symbol> = asked.iter().flat_map(|s| members(w, *s)).chain(asked.iter().copied()).collect();
    listed.extend(gone.difference(&own).map(|s| w.address(*s)));
    if !listed.is_empty() && !dependents {
        let what = format!("{} is still used", ca_model::suggest::listed(names.iter().map(String::as_str)));
        let help =
            format!("delete what refers to it too: {}", ca_model::suggest::listed(listed.iter().map(String::as_str)));
        return Err(Refusal { dependents: listed.into_iter().collect(), ..Refusal::new(what, help) });
    }
    add_empty_presets(w, &mut paths);
    edits.extend(w.layout().remove(&paths));
    Ok(Edited::new(w.text(), edits))
}

fn part(index: usize) -> Symbol {
    Symbol { scope: None, class: Class::Part, index }
}

/// Returns what is deleted with a group or a part, because it is in it.
fn members(w: &Written, symbol: Symbol) -> Vec<Symbol> {
    let modules = |scope, of: &dyn Fn(Option<usize>) -> bool| -> Vec<Symbol> {
        let all = w.body(scope).items.iter().enumerate().filter(|(_, i)| of(i.group));
        all.map(|(index, _)| Symbol { scope, class: Class::Module, index }).collect()
    };
    match symbol.class {
        Class::Group => modules(symbol.scope, &|g| g == Some(symbol.index)),
        Class::Part => {
            let scope = Some(symbol.index);
            let body = w.body(scope);
            let all = |class, n: usize| (0..n).map(move |index| Symbol { scope, class, index });
            let groups = all(Class::Group, body.groups.len()).chain(all(Class::Instance, body.uses.len()));
            modules(scope, &|_| true).into_iter().chain(groups).chain(all(Class::Param, body.params.len())).collect()
        }
        _ => Vec::new(),
    }
}

/// Adds presets that would become empty, since a preset must set something.
fn add_empty_presets(w: &Written, paths: &mut Paths) {
    for p in &w.model.presets {
        let Value::Table(values) = &p.value else { continue };
        let gone = |e: &Entry| w.path_at(e.key_span.start).is_some_and(|at| paths.cover(at));
        if !values.is_empty() && values.iter().all(gone) {
            paths.add(vec!["preset".into(), p.key.clone()]);
        }
    }
}

/// Writes the value of a parameter where its name was.
fn inline(w: &Written, r: &Reference, symbol: Symbol) -> Result<TextEdit, Refusal> {
    let place = match &r.owner {
        Owner::Of(s, key) => format!("{}.{key}", w.address(*s)),
        Owner::Entry(path) => path.join("."),
    };
    let refuse = || {
        let what = format!("the value of `{}` cannot be written at `{}`", w.address(symbol), shown(&place));
        Refusal::new(what, "write a value there first")
    };
    let entry = &w.body(symbol.scope).params[symbol.index];
    let value = value_of(entry).ok_or_else(refuse)?;
    let [hit] = r.hits.as_slice() else { return Err(refuse()) };
    if hit.at == (0..r.text.len()) {
        let toml = match value {
            Value::Num(v) => format!("{v:?}"),
            Value::Text(t) => quoted(&t),
            Value::Bool(b) => b.to_string(),
            _ => return Err(refuse()),
        };
        return Ok(TextEdit::new(r.range.clone(), toml));
    }
    // a product, a place or a longer selector
    let text = match (product(&r.text), &value) {
        (Some((factor, _)), Value::Num(v)) => return Ok(TextEdit::new(r.range.clone(), format!("{:?}", factor * v))),
        (Some((factor, _)), Value::Text(t)) => {
            let q = quantity::parse(t).ok().filter(|q| q.has_unit);
            let (value, unit) = match q {
                Some(q) => (q.value, quantity::unit_of(q.dim)),
                None => (quantity::note(t).ok_or_else(refuse)?, "Hz".into()),
            };
            format!("{} {unit}", Plain(quantity::rounded(factor * value, 12)))
        }
        (None, Value::Num(v)) => format!("{}{v}{}", &r.text[..hit.at.start], &r.text[hit.at.end..]),
        (None, Value::Text(t)) => format!("{}{t}{}", &r.text[..hit.at.start], &r.text[hit.at.end..]),
        _ => return Err(refuse()),
    };
    Ok(TextEdit::new(r.range.clone(), quoted(&text)))
}

/// Returns the value of a parameter; for one that a port drives, its smallest.
fn value_of(param: &Entry) -> Option<Value> {
    let Value::Table(t) = &param.value else { return Some(param.value.clone()) };
    let of = |key: &str| t.iter().find(|e| e.key == key).map(|e| e.value.clone());
    let value = of("value").or_else(|| of("min"))?;
    match (&value, of("unit")) {
        (Value::Num(v), Some(Value::Text(unit))) if !unit.is_empty() => {
            Some(Value::Text(format!("{} {unit}", Plain(*v))))
        }
        _ => Some(value),
    }
}
