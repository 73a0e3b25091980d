//! Reads `[param]`, named numbers that may be live, and places them in the network.

use crate::findings::{bad_quantity, inside, range_help, type_name, wrong_unit};
use crate::lower::parsed_param::{ParsedParam, Raw};
use crate::lower::values::Values;
use crate::net::{NetDriven, Resolved};
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::internal::kind::alg_to_si;
use ca_core::{ANY, Dim, InputRole, LiveParam, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::{Plain, Quantity};
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Span, Value, quantity};

const KEYS: &[&str] = &["value", "unit", "live", "min", "max", "port", "span", "doc"];

/// Reads the parameters of a model.
pub fn all(model: &Model, diags: &mut Diags) -> Vec<ParsedParam> {
    let lost = model.lost.iter().map(|name| ParsedParam::broken(name, Span::NONE));
    let keys: BTreeSet<&str> = model.params.iter().map(|e| e.key.as_str()).collect();
    let is_param = |name: &str| keys.contains(name);
    let mut list: Vec<ParsedParam> = model.params.iter().map(|e| named(e, &is_param, diags)).collect();
    list.extend(lost);
    list
}

fn raw(e: &Entry, what: &str, is_param: &dyn Fn(&str) -> bool, diags: &mut Diags) -> Option<Raw> {
    match &e.value {
        Value::Num(v) if v.is_finite() => Some(Raw::Bare(*v)),
        Value::Num(v) => {
            let d = Diag::error("E009", format!("{what} is out of range: {v}")).at(e.span, "out of range");
            diags.push(d.help("use a finite number"));
            None
        }
        Value::Text(t) if quantity::is_quantity(t) && !quantity::product(t).is_some_and(|(_, name)| is_param(name)) => {
            match quantity::parse(t) {
                Ok(q) => Some(Raw::Quantity(q)),
                Err(err) => {
                    diags.push(bad_quantity(what, e, t, &err, None));
                    None
                }
            }
        }
        // A parameter takes precedence over a note of the same name.
        Value::Text(t)
            if !is_param(t)
                && let Some(value) = quantity::note(t) =>
        {
            Some(Raw::Quantity(Quantity { value, dim: Unit::HERTZ.dim, has_unit: true }))
        }
        other => {
            let title = format!("{what} must be a number or a quantity, not {}", type_name(other));
            let d = Diag::error("E006", title).at(e.span, "not a number");
            let note = if let Value::Text(t) = other { quantity::near_note(t) } else { None };
            diags.push(match note {
                Some(note) => d.help(format!("did you mean `{note}`?")).fix(e.span, format!("\"{note}\"")),
                None => {
                    d.help("write e.g. `0.5`, `\"8 kN/m\"` or `\"A4\"`; a parameter cannot refer to other parameters")
                }
            });
            None
        }
    }
}

/// A bare number in the unit of its parameter; other values as they are.
fn in_unit(x: &Entry, unit: Option<&str>) -> Entry {
    match (&x.value, unit) {
        (Value::Num(v), Some(unit)) if v.is_finite() => {
            Entry { value: Value::Text(format!("{v:e} {unit}")), ..x.clone() }
        }
        _ => x.clone(),
    }
}

/// The value of a line of `[param]`, called `what` in reports; nothing where it was reported.
pub fn raw_value(e: &Entry, what: &str, diags: &mut Diags) -> Option<Raw> {
    let Value::Table(entries) = &e.value else { return raw(e, what, &|_| false, diags) };
    let of = |key: &str| entries.iter().find(|x| x.key == key);
    let unit = of("unit").and_then(|x| if let Value::Text(t) = &x.value { Some(t.as_str()) } else { None });
    raw(&in_unit(of("value")?, unit.filter(|u| !u.is_empty())), what, &|_| false, diags)
}

fn named(e: &Entry, is_param: &dyn Fn(&str) -> bool, diags: &mut Diags) -> ParsedParam {
    let what = format!("parameter `{}`", e.key);
    let mut n = ParsedParam { value_span: e.span, ..ParsedParam::broken(&e.key, e.key_span) };
    let Value::Table(entries) = &e.value else {
        n.value = raw(e, &what, is_param, diags);
        return n;
    };
    let text = |key: &str| match entries.iter().find(|x| x.key == key).map(|x| (&x.value, x.span)) {
        Some((Value::Text(t), span)) => Some((t.clone(), span)),
        _ => None,
    };
    // A bare number with `unit = "…"` in the table is a quantity.
    let mut unit = text("unit").filter(|u| !u.0.is_empty());
    if let Some((u, span)) = &unit {
        let asked = format!("1 {u}");
        if let Err(err) = quantity::parse(&asked) {
            let text = u.clone();
            let (from, to) = (err.at.saturating_sub(2), err.end.saturating_sub(2));
            let place = inside(*span, &text, from, to.max(from + 1));
            let d = Diag::error("E007", format!("`unit` of {what}: {}", err.message)).at(place, "not a unit");
            diags.push(match &err.hint {
                Some(h) if place != *span => d.help(format!("did you mean `{h}`?")).fix(place, h.clone()),
                Some(h) => d.help(format!("did you mean `{h}`?")),
                None => d.help("units are made of m, g, s, Hz, N, J, W and prefixes, e.g. `N s/m`"),
            });
            unit = None;
            // Further findings would repeat this one.
            if !entries.iter().any(|x| x.key == "value" && matches!(x.value, Value::Text(_))) {
                return n;
            }
        }
    }
    if let Some((u, _)) = &unit {
        let bare = |x: &&Entry| {
            let number = matches!(&x.value, Value::Text(t) if quantity::parse(t).is_ok_and(|q| !q.has_unit));
            number && matches!(x.key.as_str(), "value" | "min" | "max")
        };
        if let Some(x) = entries.iter().find(bare)
            && let Value::Text(t) = &x.value
        {
            let of = if x.key == "value" { what.clone() } else { format!("`{}` of {what}", x.key) };
            let d = Diag::error("E008", format!("{of} has no unit: `{}`", t.trim())).at(x.span, "without a unit");
            let (t, help) =
                (t.trim(), "a number in quotes needs a unit; one without quotes has the unit of the parameter");
            diags.push(d.help(format!("write `\"{t} {u}\"`: {help}")).fix(x.span, format!("\"{t} {u}\"")));
            return n;
        }
    }
    let with_unit = |x: &Entry| in_unit(x, unit.as_ref().map(|u| u.0.as_str()));
    let mut spans = [Span::NONE; 2];
    for x in entries {
        match (x.key.as_str(), &x.value) {
            ("value", _) => {
                n.value = raw(&with_unit(x), &what, is_param, diags);
                n.value_span = x.span;
            }
            ("min", _) => {
                (n.min, spans[0]) = (raw(&with_unit(x), &format!("`min` of {what}"), is_param, diags), x.span);
            }
            ("max", _) => {
                (n.max, spans[1]) = (raw(&with_unit(x), &format!("`max` of {what}"), is_param, diags), x.span);
            }
            ("live", Value::Bool(b)) => n.live = *b,
            ("port", Value::Text(_)) => (n.port, n.live) = (Some(x.clone()), true),
            ("span", Value::List(_)) => n.span_of_port = Some(x.clone()),
            ("unit" | "doc", Value::Text(_)) => {}
            ("span", other) => {
                let title = format!("`span` of {what} must be a list of two numbers, not {}", type_name(other));
                let d = Diag::error("E006", title).at(x.span, "wrong type");
                diags.push(d.help("write the values of the port at `min` and at `max`, e.g. `span = [0, \"20 mm\"]`"));
            }
            ("live", other) => {
                let d = Diag::error(
                    "E006",
                    format!("`live` of {what} must be `true` or `false`, not {}", type_name(other)),
                );
                diags.push(d.at(x.span, "wrong type").help("write `live = true`").fix(x.span, "true"));
            }
            ("unit" | "doc" | "port", other) => {
                let d = Diag::error("E006", format!("`{}` of {what} must be a text, not {}", x.key, type_name(other)));
                diags.push(d.at(x.span, "wrong type").help("put it in quotes"));
            }
            _ => {
                let d =
                    Diag::error("E004", format!("unknown key in {what}: `{}`", x.key)).at(x.key_span, "not known here");
                diags.push(match nearest(&x.key, KEYS.iter().copied()) {
                    Some(near) => d.help(format!("did you mean `{near}`?")).fix(x.key_span, near),
                    None => {
                        d.help("a parameter has `value`, `unit`, `live`, `min`, `max`, `doc`, and `port` with `span`")
                    }
                });
            }
        }
    }
    n.doc = text("doc").map(|d| d.0).unwrap_or_default();
    if n.port.is_some() {
        driven(&mut n, e, &what, diags);
    } else if !entries.iter().any(|x| x.key == "value") {
        let d = Diag::error("E005", format!("{what} has no `value`")).at(e.key_span, "without `value`");
        diags.push(d.help("add e.g. `value = 0.5`, or `value = \"8 kN/m\"`"));
    }
    limits(&mut n, spans, &what, diags);
    n
}

/// Checks a parameter that a port drives: it needs bounds and a span, and has its smallest value until the port is
/// read.
fn driven(n: &mut ParsedParam, e: &Entry, what: &str, diags: &mut Diags) {
    let missing = [("min", n.min.is_none()), ("max", n.max.is_none()), ("span", n.span_of_port.is_none())];
    for (key, _) in missing.into_iter().filter(|m| m.1) {
        let broken = matches!(&e.value, Value::Table(t) if t.iter().any(|x| x.key == key));
        if !broken {
            let d = Diag::error("E005", format!("{what} has a `port`, but no `{key}`")).at(e.key_span, "incomplete");
            diags.push(d.help(
                "the port drives it from `min` to `max` as the port goes from the first to the second value of `span`, \
                 e.g. `{ port = \"press\", span = [0, \"20 mm\"], min = 0, max = \"2 N\" }`",
            ));
        }
        n.port = None;
    }
    // 0 needs no unit.
    let least = match (n.min, n.max) {
        (Some(Raw::Bare(0.0)), Some(Raw::Quantity(q))) => Some(Raw::Quantity(quantity::Quantity { value: 0.0, ..q })),
        (min, _) => min,
    };
    n.value = n.value.or(least);
}

/// Checks that `min` and `max` have the dimension of `value` and are in order, with `value` between them.
fn limits(n: &mut ParsedParam, spans: [Span; 2], what: &str, diags: &mut Diags) {
    let Some(value) = n.value else { return };
    let dim = |r: Raw| match r {
        Raw::Quantity(q) if q.has_unit => Some(q.dim),
        _ => None,
    };
    let limits = [("min", n.min, spans[0]), ("max", n.max, spans[1])];
    for (key, limit, span) in limits {
        let Some(limit) = limit else { continue };
        let (a, b) = (dim(value), dim(limit));
        // 0 needs no unit.
        let nothing = limit.number() == 0.0;
        if nothing || matches!((a, b), (None, None)) || matches!((a, b), (Some(a), Some(b)) if a.same(b)) {
            continue;
        }
        diags.push(not_alike(n, what, key, span, [a, b]));
        (n.min, n.max) = (None, None);
        return;
    }
    let (low, high) = (n.min.map(Raw::number), n.max.map(Raw::number));
    if let (Some(a), Some(b)) = (low, high) {
        if a > b {
            let d = Diag::error("E009", format!("{what}: `min` is above `max`"))
                .at(spans[0], "smallest")
                .at(spans[1], "largest");
            diags.push(d.help("swap the two"));
            (n.min, n.max) = (None, None);
            return;
        }
    }
    let v = value.number();
    if low.is_some_and(|a| v < a) || high.is_some_and(|b| v > b) {
        let unit = dim(value).map_or(String::new(), quantity::unit_of);
        let show = |v: f64| if unit.is_empty() { format!("{}", Plain(v)) } else { format!("{} {unit}", Plain(v)) };
        let d = Diag::error("E009", format!("{what} is outside its own range: {}", show(v)));
        let (a, b) = (low.unwrap_or(f64::MIN), high.unwrap_or(f64::MAX));
        diags.push(d.at(n.value_span, "out of range").help(range_help(a, b, show)));
    }
}

/// Returns the error for a value and a limit of different units. It blames the plain number of the two, or a value that
/// was set and so is not in the text.
fn not_alike(n: &ParsedParam, what: &str, key: &str, span: Span, [value, limit]: [Option<Dim>; 2]) -> Diag {
    let [is, of] = [value, limit].map(|d| d.map_or(String::new(), quantity::unit_of));
    let in_unit = |unit: &str| if unit.is_empty() { "a plain number".into() } else { format!("in {unit}") };
    let help = "give the value and its limits in the same unit, e.g. with `unit = \"…\"`";
    let was_set = span.is_some() && !n.value_span.is_some();
    if value.is_some() && !was_set {
        let d = if limit.is_some() {
            wrong_unit(&format!("`{key}` of {what}"), &is, &of, span)
        } else {
            let title = format!("`{key}` of {what} is a plain number, but its value is in {is}");
            Diag::error("E008", title).at(span, "a plain number")
        };
        return d.at(n.value_span, "the value").help(help);
    }
    let title = format!("the value of {what} is {}, but its `{key}` is {}", in_unit(&is), in_unit(&of));
    let d = Diag::error("E008", title);
    if !was_set {
        return d.at(n.value_span, "a plain number").at(span, format!("this is in {of}")).help(help);
    }
    let v = Plain(n.value.map_or(0.0, Raw::number));
    d.help(format!("set the value in the unit of the file, e.g. `{}={}`", n.name, format!("{v} {of}").trim_end()))
}

/// Moves the parameters into the network and records the unused ones.
pub fn place(v: &mut Values<'_>, net: &mut Resolved) {
    let mut renumber = alloc::vec![usize::MAX; v.named.len()];
    for (i, n) in v.named.iter().enumerate() {
        let Some(raw) = n.value else { continue };
        if n.used.is_none() {
            net.unused.push((n.name.clone(), n.span));
        }
        if !n.live {
            net.constants.insert(n.name.clone(), raw.number());
            continue;
        }
        let (unit, min, max) = n.used.unwrap_or((Unit::NONE, f64::MIN, f64::MAX));
        let factor = if matches!(raw, Raw::Bare(_)) { v.alg.map_or(1.0, |tr| alg_to_si(unit.dim, tr)) } else { 1.0 };
        renumber[i] = net.params.len();
        net.params.push(LiveParam {
            name: n.name.clone(),
            unit,
            // A declared range never widens the range at the place of use.
            min: n.min.map_or(min / factor, Raw::number).max(min / factor),
            max: n.max.map_or(max / factor, Raw::number).min(max / factor),
            value: raw.number(),
            doc: n.doc.clone(),
        });
    }
    let by_ports: Vec<(usize, ParsedParam)> =
        v.named.iter().cloned().enumerate().filter(|n| n.1.port.is_some()).collect();
    for (i, n) in by_ports.iter().filter(|n| renumber[n.0] != usize::MAX) {
        let driven = drives(n, net, v).map(|drive| NetDriven { param: renumber[*i], ..drive });
        net.driven.extend(driven);
    }
    for item in &mut net.items {
        for f in &mut item.follows {
            f.1 = renumber[f.1];
        }
    }
}

/// Returns the port that drives a parameter, with its span.
fn drives(n: &ParsedParam, net: &Resolved, v: &mut Values<'_>) -> Option<NetDriven> {
    let (port, span) = (n.port.as_ref()?, n.span_of_port.as_ref()?);
    let Value::Text(name) = &port.value else { return None };
    let Some(input) = net.inputs.iter().position(|i| i.name == *name) else {
        let d = Diag::error("E021", format!("parameter `{}` is driven by `{name}`, which is not a port", n.name));
        let d = d.at(port.span, "no such port");
        v.diags.push(match nearest(name, net.inputs.iter().map(|i| i.name.as_str())) {
            Some(near) => d.help(format!("did you mean `{near}`?")).fix(port.span, format!("\"{near}\"")),
            None => d.help("name an ENX, a TGR or an ENF; for a port in space, add `.x`, `.y` or `.z`"),
        });
        return None;
    };
    let unit = if net.inputs[input].role == InputRole::Force { Unit::NEWTON } else { Unit::METRE };
    let what = format!("`span` of parameter `{}`", n.name);
    let Value::List(ends) = &span.value else { return None };
    let [from, to] = &ends[..] else {
        let d =
            Diag::error("E019", format!("{what} must have two values, not {}", ends.len())).at(span.span, "not a pair");
        v.diags.push(d.help("write the values of the port at `min` and at `max`, e.g. `span = [0, \"20 mm\"]`"));
        return None;
    };
    let span = [from, to].map(|e| v.constant(e, unit, ANY, &what));
    let [Some(from), Some(to)] = span else { return None };
    if from == to {
        let d = Diag::error("E009", format!("{what} has two equal values")).at(n.span, "declared here");
        v.diags.push(d.help("write two different values of the port"));
        return None;
    }
    Some(NetDriven { input: input as u32, span: [from, to], param: 0, at: n.span })
}

/// Reports parameters that no module and no moving point follows.
pub fn report_unused(net: &Resolved, diags: &mut Diags) {
    for (name, span) in &net.unused {
        let d = Diag::warning("W109", format!("parameter `{name}` is not used")).at(*span, "declared here");
        let short = name.rsplit('.').next().unwrap_or(name);
        diags.push(d.help(format!("use `\"{short}\"` as a value in a module, or remove the parameter")));
    }
}
