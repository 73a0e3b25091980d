//! Warns of contacts that are pressed at load. For a set, only the first pair is reported.

use crate::net::{End, LiaNode, Measure, Pruned};
use alloc::format;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_core::internal::op::layout::PairSet;
use ca_core::internal::op::links::measure::measure;
use ca_core::internal::op::links::pair_set;
use ca_core::internal::op::{loaded, started};
use ca_model::diag::{Diag, Diags};
use ca_model::{Model, quantity};

/// Warns if `l` is pressed at load, once per item.
pub fn warn(net: &Pruned, l: &LiaNode, e0: f64, reach: &[[f64; 4]; 2], model: &Model, diags: &mut Diags) {
    let found = if l.sets.is_some() { of_set(net, l) } else { of_pair(net, l, e0, reach) };
    let Some((ends, e, f)) = found else { return };
    let item = &model.items[net.items[l.item as usize].model];
    let known = |d: &Diag| d.code == "W102" && d.span() == item.name_span && item.name_span.is_some();
    if diags.list.iter().any(known) {
        return;
    }
    let (a, b) = (net.end_name(ends[0]), net.end_name(ends[1]));
    // Three digits are enough to find the position.
    let three = |v: f64| format!("{:.2e}", v.abs()).parse().unwrap_or(v.abs());
    let force = quantity::show(three(f), Unit::NEWTON);
    let d = Diag::warning("W102", format!("`{}` already presses at load, with a force of {force}", l.name));
    let gap = quantity::show(three(e), Unit::METRE);
    let (label, help) = if l.is_radial() {
        let way = if f < 0.0 { "move them apart" } else { "move them closer" };
        (format!("`{b}` is {gap} from `{a}`"), format!("{way} by `x` or `dx0`, or change `d`"))
    } else {
        let side = if e < 0.0 { "below" } else { "above" };
        let way = "swap the ends of `between`, or move one of them by `x` or `dx0`";
        (format!("`{b}` is {gap} {side} `{a}`"), format!("the contact keeps `{b}` above `{a}`: {way}"))
    };
    diags.push(d.at(item.name_span, label).help(help));
}

/// Pressed ends, elongation \[m\] and force \[N\].
type Pressed = ([End; 2], f64, f64);

fn coefs(net: &Pruned, l: &LiaNode) -> Vec<f64> {
    loaded(l.law, &net.values(l.item, &l.values), net.tick_dt)
}

/// Returns the force \[N\] of a contact that starts at elongation `e`.
fn force(net: &Pruned, l: &LiaNode, c: &[f64], e: f64) -> f64 {
    (l.law.fns.force)(c, &mut started(l.law, c, e), &net.tables, e, 0.0)
}

fn of_pair(net: &Pruned, l: &LiaNode, e0: f64, reach: &[[f64; 4]; 2]) -> Option<Pressed> {
    let elongation = |ends: [End; 2], m: Measure, reach: &[f64; 4]| {
        let at = ends.map(|e| if let End::Mat(m) = e { net.mats[m as usize].dx0 } else { [0.0; 3] });
        let places = match m {
            Measure::Line([a, b]) => [at[0][a as usize], 0.0, 0.0, at[1][b as usize], 0.0, 0.0],
            _ => [at[0][0], at[0][1], at[0][2], at[1][0], at[1][1], at[1][2]],
        };
        measure(m.measure(), &places, &[0.0; 6], [0, 3], reach).e
    };
    let second = l.onto.as_ref().map_or(0.0, |o| elongation(o.ends, o.measure, &reach[1]));
    let e = e0 + elongation(l.ends, l.measure, &reach[0]) + second;
    let c = coefs(net, l);
    let f = force(net, l, &c, e);
    (f != 0.0).then_some((l.ends, e, f))
}

fn of_set(net: &Pruned, l: &LiaNode) -> Option<Pressed> {
    let sets = l.sets.as_deref()?;
    let members = || sets.iter().flatten().map(|m| &net.mats[*m as usize]);
    // The members alone, with three slots each.
    let rest: Vec<f64> = members().flat_map(|m| m.rest).collect();
    let x: Vec<f64> = members().flat_map(|m| m.dx0).collect();
    let places = [0..sets[0].len(), sets[0].len()..rest.len() / 3].map(|r| r.map(|k| 3 * k as u32).collect::<Vec<_>>());
    let set = PairSet::new([&places[0], &places[1]]);
    let c = coefs(net, l);
    let (i, j, e, f) = pair_set::pressed(&set, &rest, &x, (l.law.fns.idle)(&c), |e| force(net, l, &c, e))?;
    let name = |k: usize| sets.iter().flatten().nth(k).map(|m| End::Mat(*m));
    Some(([name(i)?, name(j)?], e, f))
}
