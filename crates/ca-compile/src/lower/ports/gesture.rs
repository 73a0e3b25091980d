//! Reads `[gesture]`: built-in gestures as points \[s, value\] for a port or a live parameter.

use crate::lower::curve::{Curves, MOST};
use crate::lower::parsed_param::ParsedParam;
use crate::lower::values::Values;
use crate::net::Resolved;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::{Input, InputRole, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Value};

/// Reads all gestures.
pub fn gestures(model: &Model, net: &mut Resolved, alg: Option<f64>, named: &[ParsedParam], diags: &mut Diags) {
    if model.gestures.is_empty() {
        return;
    }
    let all: BTreeMap<&str, &Entry> = model.gestures.iter().map(|e| (e.key.as_str(), e)).collect();
    // Unit and limits of everything that a gesture may drive.
    let params = net.params.iter().map(|p| (p.name.clone(), (p.unit, Some((p.min, p.max)))));
    let force = |i: &Input| if i.role == InputRole::Force { Unit::NEWTON } else { Unit::METRE };
    let ports = net.inputs.iter().map(|i| (i.name.clone(), (force(i), None)));
    let driven: BTreeMap<String, (Unit, Option<(f64, f64)>)> = params.chain(ports).collect();
    let by_port: BTreeMap<String, u32> =
        net.driven.iter().map(|d| (net.params[d.param].name.clone(), d.input)).collect();
    let units = |name: &str| driven.get(name).map(|d| d.0);
    let (mut made, mut spent) = (BTreeMap::new(), 0);
    let mut v = Values::new(None, diags);
    v.name(named.to_vec());
    for e in &model.gestures {
        let Some((unit, limits)) = driven.get(&e.key).copied() else {
            drives_nothing(e, model, net, named, v.diags);
            continue;
        };
        if let Some(input) = by_port.get(&e.key) {
            let port = &net.inputs[*input as usize].name;
            let d = Diag::error("E021", format!("gesture `{}` drives a parameter that a port already drives", e.key));
            v.diags.push(d.at(e.key_span, "driven by a port").help(format!("let the gesture drive `{port}` instead")));
            continue;
        }
        let what = format!("gesture `{}`", e.key);
        let (alg, within) = (alg.filter(|_| limits.is_none()), Vec::from([e.key.clone()]));
        let curves = Curves { v: &mut v, net, all: &all, unit, units: &units, alg, following: within, made: &mut made };
        let points = { curves }.curve(e, &what);
        let mut used = BTreeSet::new();
        refer(&e.value, &mut |name| _ = used.insert(name.to_string()));
        if !used.is_empty() {
            net.unused.retain(|u| !used.contains(&u.0));
        }
        let Some(points) = points else { continue };
        spent += points.len();
        if spent > MOST {
            let d = Diag::error("E027", format!("the gestures have more than {MOST} points"));
            let help = "end some of them sooner, or play them from files";
            v.diags.push(d.at(e.key_span, "with this one").help(help));
            return;
        }
        if let Some([t, x]) = points.iter().find(|p| !(p[0].is_finite() && p[1].is_finite())) {
            let title = format!("{what} does not have a finite value at {} s: {}", Plain(*t), Plain(*x));
            v.diags.push(Diag::error("E009", title).at(e.span, "out of range").help("use smaller numbers"));
            continue;
        }
        let span = |i: usize| if let Value::List(l) = &e.value { l.get(i).map_or(e.span, |p| p.span) } else { e.span };
        if let Some((min, max)) = limits {
            if let Some(i) = points.iter().position(|p| p[1] < min || p[1] > max) {
                let title = format!("{what} leaves the range of the parameter: {}", Plain(points[i][1]));
                let d = Diag::error("E009", title).at(span(i), "out of range");
                let help = crate::findings::range_help(min, max, |v| format!("{}", Plain(v)));
                v.diags.push(d.help(help));
                continue;
            }
        }
        net.gestures.push((e.key.clone(), points));
    }
}

/// Calls `named` for every text in a value.
fn refer(value: &Value, named: &mut dyn FnMut(&str)) {
    match value {
        Value::Text(t) => named(t),
        Value::List(l) | Value::Table(l) => l.iter().for_each(|e| refer(&e.value, named)),
        _ => {}
    }
}

fn drives_nothing(e: &Entry, model: &Model, net: &Resolved, named: &[ParsedParam], diags: &mut Diags) {
    let mut d = Diag::error("E021", format!("gesture `{}` drives nothing", e.key));
    if let Some(n) = named.iter().find(|n| n.name == e.key) {
        if n.value.is_none() {
            return; // reported at its declaration
        }
        d = d.at(e.key_span, "not a live parameter").at(n.span, "declared here, not live");
        diags.push(d.help(format!("declare it as `{} = {{ value = …, live = true }}`", e.key)));
        return;
    }
    if let Some(item) = model.items.iter().find(|i| i.name == e.key) {
        if matches!(item.kind.as_str(), "ENX" | "ENF" | "TGR") || !net.items.iter().any(|i| *i.name == *e.key) {
            return; // broken, and reported at its own place
        }
        d = d.at(e.key_span, "not a port").at(item.name_span, format!("{} cannot follow a gesture", item.kind));
        diags.push(d.help(format!(
            "link it to an ENX that the gesture drives, or push it by an ENF with `to = \"{}\"`",
            e.key
        )));
        return;
    }
    d = d.at(e.key_span, "neither a port nor a live parameter");
    let names = || net.inputs.iter().map(|i| i.name.as_str()).chain(net.params.iter().map(|p| p.name.as_str()));
    if let Some(near) = nearest(&e.key, names()) {
        let new = if near.contains('[') { format!("\"{near}\"") } else { near.into() };
        d = d.help(format!("did you mean `{near}`?")).fix(e.key_span, new);
    } else if names().next().is_some() {
        let all: Vec<_> = names().take(12).map(|n| format!("`{n}`")).collect();
        d = d.help(format!("a gesture drives an ENX, ENF or TGR, or a live parameter: {}", all.join(", ")));
    } else {
        d = d.help("a gesture drives an ENX, ENF or TGR, or a `[param]` with `live = true`; the model has none");
    }
    diags.push(d);
}
