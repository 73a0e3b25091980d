//! Checks of ports: gestures that begin elsewhere than their port, and ports on one degree of freedom.
//!
//! A gesture that displaces its port at load gives a warning if the port has links: they store energy from the start,
//! and the scene begins with a blow. Several ports on one degree of freedom are legitimate, so they give a note. Ports
//! that follow different notes or controllers give none: MIDI plays such a model, and its parts use the default of
//! `dof`.

use crate::net::{End, MatRole, Wired};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::{Input, InputRole, Unit};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, Span, Value, quantity};

/// Accepted distance between the first point of a gesture and its port \[m\].
const THERE: f64 = 1e-6;
/// The same as a share of the range of the gesture: noise on a stroke is part of the stroke.
const OF_WAY: f64 = 0.01;

/// Runs both checks.
pub fn check(model: &Model, net: &Wired, diags: &mut Diags) {
    jumps(model, net, diags);
    shared(model, net, diags);
}

fn jumps(model: &Model, net: &Wired, diags: &mut Diags) {
    if net.resolved.gestures.is_empty() {
        return;
    }
    let mut tied = alloc::vec![false; net.resolved.inputs.len()];
    for end in net.resolved.lias.iter().flat_map(|l| l.all_ends()) {
        let End::Mat(m) = end else { continue };
        if let Some(MatRole::Port(_, inputs)) = net.resolved.mats.get(m as usize).map(|m| m.role) {
            for i in inputs.into_iter().flatten() {
                tied[i as usize] = true;
            }
        }
    }
    let of: BTreeMap<&str, usize> =
        net.resolved.inputs.iter().enumerate().map(|(at, i)| (i.name.as_str(), at)).collect();
    for (name, points) in &net.resolved.gestures {
        let Some(at) = of.get(name.as_str()).copied() else { continue };
        let input = &net.resolved.inputs[at];
        let Some([_, first]) = points.first() else { continue };
        let (low, high) = points.iter().fold((*first, *first), |(a, b), p| (a.min(p[1]), b.max(p[1])));
        let there = THERE.max(OF_WAY * (high - low));
        if !tied[at] || input.role == InputRole::Force || (first - input.rest).abs() <= there {
            continue;
        }
        let e = model.gestures.iter().find(|e| e.key == *name);
        let span = e.map_or(Span::NONE, |e| match &e.value {
            Value::List(l) => l.first().map_or(e.span, |p| p.span),
            _ => e.span,
        });
        let [first, rest] = [*first, input.rest].map(|v| quantity::show(quantity::six(v), Unit::METRE));
        let title = format!("gesture `{name}` begins at {first}, but its port is at {rest}");
        let d = Diag::warning("W116", title).at(span, "stretches the links of the port at load");
        diags.push(d.help(format!("begin the gesture at \"{rest}\", or give the port `x = \"{first}\"`")));
    }
}

fn shared(model: &Model, net: &Wired, diags: &mut Diags) {
    let mut by: BTreeMap<(&str, u32), Vec<&Input>> = BTreeMap::new();
    for i in &net.resolved.inputs {
        if let Some((device, dof)) = &i.device {
            by.entry((device, *dof)).or_default().push(i);
        }
    }
    for ((device, dof), ports) in by.into_iter().filter(|p| p.1.len() > 1 && !are_distinct(&p.1)) {
        let all: Vec<String> = ports.iter().take(3).map(|p| format!("`{}`", p.name)).collect();
        let more = if ports.len() > 3 { format!(" and {} more", ports.len() - 3) } else { String::new() };
        let title = format!(
            "degree of freedom {dof} of `{device}` moves {} ports at once: {}{more}",
            ports.len(),
            all.join(", ")
        );
        let item = model.items.iter().find(|i| i.name == ports[1].name);
        let entry = item.and_then(|i| i.args.iter().find(|e| e.key == "dof"));
        let span = entry.map(|e| e.span).or(item.map(|i| i.name_span)).unwrap_or(Span::NONE);
        let help = "this is right if one key should move them all; otherwise give each a different `dof`, for instances \
                    by a list in `with`: `dof = [0, 1, …]`";
        diags.push(Diag::note("N204", title).at(span, "the same degree of freedom").help(help));
    }
}

/// Returns whether all these ports follow MIDI, each a different source.
fn are_distinct(ports: &[&Input]) -> bool {
    let by = |i: &&Input| i.midi.map(|m| (m.source, m.channel));
    ports.iter().enumerate().all(|(k, i)| by(i).is_some() && !ports[..k].iter().any(|other| by(other) == by(i)))
}
