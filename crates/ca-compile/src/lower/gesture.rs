//! `[gesture]`: what the model plays by itself, as points \[s, value\] for a port or a live parameter.

use crate::lower::named::Named;
use crate::lower::values::Values;
use crate::net::Resolved;
use alloc::format;
use alloc::vec::Vec;
use ca_core::kind::Unit;
use ca_core::scene::InputRole;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::suggest::nearest;
use ca_model::{Entry, Model, Value};

/// Reads all gestures.
pub fn gestures(model: &Model, net: &mut Resolved, alg: Option<f64>, named: &[Named], diags: &mut Diags) {
    for e in &model.gestures {
        let input = net.inputs.iter().find(|i| i.name == e.key);
        let param = net.params.iter().find(|p| p.name == e.key);
        let unit = match (input, param) {
            (Some(i), _) if i.role == InputRole::Force => Unit::NEWTON,
            (Some(_), _) => Unit::METRE,
            (None, Some(p)) => p.unit,
            (None, None) => {
                drives_nothing(e, model, net, named, diags);
                continue;
            }
        };
        if let Some(d) = net.driven.iter().find(|d| net.params[d.param].name == e.key) {
            let port = &net.inputs[d.input as usize].name;
            let d = Diag::error("E021", format!("gesture `{}` drives a parameter that a port drives", e.key));
            diags.push(d.at(e.key_span, "driven by a port").help(format!("let it move `{port}` instead")));
            continue;
        }
        let limits = param.map(|p| (p.min, p.max));
        // times are seconds in every unit system; only the values follow the model's units
        let mut v = Values::new(None, diags);
        let what = format!("gesture `{}`", e.key);
        let Some(mut points) = v.points(e, Unit::SECOND, unit, &what) else { continue };
        let Value::List(list) = &e.value else { continue };
        if let Some(tr) = alg {
            for (p, written) in points.iter_mut().zip(list) {
                if let Value::List(pair) = &written.value {
                    if matches!(pair[1].value, Value::Num(_)) && param.is_none() {
                        p[1] *= unit.dim.alg_to_si(tr);
                    }
                }
            }
        }
        if points.is_empty() {
            let d = Diag::error("E019", format!("{what} has no points")).at(e.span, "empty");
            diags.push(d.help("write `[[seconds, value], …]`, times rising"));
            continue;
        }
        let back = (1..points.len()).find(|i| points[*i][0] < points[i - 1][0]);
        if let Some(i) = back {
            let d = Diag::error(
                "E019",
                format!("{what} goes back in time: {} s after {} s", Plain(points[i][0]), Plain(points[i - 1][0])),
            );
            let d = d.at(list[i].span, "earlier than the point before").at(list[i - 1].span, "the point before");
            diags.push(d.help("write the points in order of time"));
            continue;
        }
        if let Some(i) = points.iter().position(|p| p[0] < 0.0) {
            let d = Diag::error("E019", format!("{what} begins before time 0: {} s", Plain(points[i][0])));
            diags.push(d.at(list[i].span, "before the beginning").help("times are seconds from the first sample"));
            continue;
        }
        if let Some((min, max)) = limits {
            if let Some(i) = points.iter().position(|p| p[1] < min || p[1] > max) {
                let title = format!("{what} leaves the range of the parameter: {}", Plain(points[i][1]));
                let d = Diag::error("E009", title).at(list[i].span, "out of range");
                let help = crate::findings::range_help(min, max, |v| format!("{}", Plain(v)));
                diags.push(d.help(help));
                continue;
            }
        }
        net.gestures.push((e.key.clone(), points));
    }
}

fn drives_nothing(e: &Entry, model: &Model, net: &Resolved, named: &[Named], diags: &mut Diags) {
    let mut d = Diag::error("E021", format!("gesture `{}` drives nothing", e.key));
    if let Some(n) = named.iter().find(|n| n.name == e.key) {
        if n.value.is_none() {
            return; // reported where it is declared
        }
        d = d.at(e.key_span, "not a live parameter").at(n.span, "declared here, not live");
        diags.push(d.help(format!("declare it as `{} = {{ value = …, live = true }}`", e.key)));
        return;
    }
    if let Some(item) = model.items.iter().find(|i| i.name == e.key) {
        if matches!(item.kind.as_str(), "ENX" | "ENF" | "TGR") || !net.items.iter().any(|i| *i.name == *e.key) {
            return; // broken, and reported where it stands
        }
        d = d.at(e.key_span, "not a port").at(item.name_span, format!("{} is not moved by a gesture", item.kind));
        diags.push(d.help(format!(
            "tie it to an ENX by a link and let the gesture move that; or push it by an ENF `to = \"{}\"`",
            e.key
        )));
        return;
    }
    d = d.at(e.key_span, "neither a port nor a live parameter");
    let names = || net.inputs.iter().map(|i| i.name.as_str()).chain(net.params.iter().map(|p| p.name.as_str()));
    if let Some(near) = nearest(&e.key, names()) {
        d = d.help(format!("did you mean `{near}`?")).fix(e.key_span, near);
    } else if names().next().is_some() {
        let all: Vec<_> = names().take(12).map(|n| format!("`{n}`")).collect();
        d = d.help(format!("a gesture drives an ENX, ENF or TGR, or a live parameter: {}", all.join(", ")));
    } else {
        d = d.help("a gesture drives an ENX, ENF or TGR, or a `[param]` with `live = true`; the model has none");
    }
    diags.push(d);
}
