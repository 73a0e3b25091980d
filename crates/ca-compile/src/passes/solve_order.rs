//! Solve order: which of the implicit links may be solved by themselves, and which are computed together.
//!
//! A link that counts on the motion all other forces would cause is right only if no other link of its kind changes
//! that motion. Decides by counting at every place that moves, so a row of contacts between separate pairs stays a row
//! of closed forms, and only those that share a mass, or a group that goes by its modes, pay for a solver.

use crate::findings::no_method;
use crate::net::worst::{worst_bounds, worst_mats};
use crate::net::{End, LiaNode, Measure, Pruned};
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::internal::op::SolveStage;
use ca_model::Model;
use ca_model::diag::Diags;

/// A contact of more than this kT²/m at a mass that goes by its modes loses its closed form: its depth is the difference of two
/// places, each rounded, and k times that is more than 1e-13 of its energy (docs/numerics.md §3.3).
const STIFFEST: f64 = 1e3;

/// Gives links that may not act alone the law that acts together; refuses those at moving points, whose motion is that
/// of several masses.
pub fn choose(model: &Model, net: &mut Pruned, arithmetic: Option<u32>, diags: &mut Diags) {
    let mut count: Vec<[u32; 3]> = alloc::vec![[0; 3]; net.mats.len()];
    let mut reported = BTreeSet::new();
    for l in net.lias.iter().filter(|l| !l.law.stage.is_explicit()) {
        if let Some(point) = l.all_ends().find(|e| matches!(e, End::Point(_))) {
            if reported.insert(l.item) {
                let title =
                    format!("the method of `{}` does not work at a moving point, `{}`", l.name, net.end_name(point));
                let help = "use `method = \"ca\"`, or a mass such as `low[8]` in its place";
                let item = &model.items[net.items[l.item as usize].model];
                diags.push(no_method(item, title, "not at moving points", help));
            }
        }
        for (m, axis) in places(net, l) {
            count[m as usize][axis as usize] += 1;
        }
    }
    let twice = |l: &LiaNode| places(net, l).into_iter().find(|(m, k)| count[*m as usize][*k as usize] > 1);
    for l in net.lias.iter().filter(|l| !l.law.stage.is_explicit() && l.onto.is_some()) {
        // no method solves four ends together with others
        if let Some((m, _)) = twice(l).filter(|_| reported.insert(l.item)) {
            let title =
                format!("`{}` shares `{}` with another link by such a method", l.name, net.mats[m as usize].name);
            let help = "use `method = \"ca\"` for one of them";
            diags.push(no_method(
                &model.items[net.items[l.item as usize].model],
                title,
                "not together with others",
                help,
            ));
        }
    }
    let shared = |l: &LiaNode| !matches!(l.measure, Measure::Line(_)) || twice(l).is_some();
    let shared: Vec<bool> = net.lias.iter().map(|l| !l.law.stage.is_explicit() && shared(l)).collect();
    refuse_shared(model, net, &shared, &mut reported, diags);
    // friction at shared masses is solved with the contacts of §3.4, whose system is linear as its own
    let rubs = |(l, shared): (&LiaNode, &bool)| *shared && !l.law.contact && !on_lines_alone(l);
    let curves = arithmetic.is_none_or(|a| a >= 6) && !net.lias.iter().zip(&shared).any(rubs);
    together(net, &shared, |l| curves && !matches!(l.measure, Measure::Radial));
}

/// True of a law whose method is for lines alone.
fn on_lines_alone(l: &LiaNode) -> bool {
    matches!(l.law.stage, SolveStage::Single(laws) if laws.space.is_none())
}

/// Refuses laws whose method is for lines alone in space, and where they share a mass though their force falls: such a step may have
/// several solutions.
fn refuse_shared(model: &Model, net: &Pruned, shared: &[bool], reported: &mut BTreeSet<u32>, diags: &mut Diags) {
    let links = || net.lias.iter().zip(shared).zip(0usize..).filter(|((l, shared), _)| **shared && on_lines_alone(l));
    if links().next().is_none() {
        return;
    }
    let bounds = worst_bounds(net);
    for ((l, _), i) in links() {
        let SolveStage::Single(laws) = l.law.stage else { continue };
        let (title, label, help) = if l.measure == Measure::Radial {
            let title = format!("the method of `{}` is for links on a line", l.name);
            (title, "in space", "use `method = \"ca\"`, or `along` for a difference along one direction")
        } else if laws.line.is_none() || bounds[i].active {
            let title = format!("the force of `{}` falls, and other links by such a method move its masses", l.name);
            (title, "not together with others", "use `method = \"ca\"` for this one")
        } else {
            continue;
        };
        if reported.insert(l.item) {
            diags.push(no_method(&model.items[net.items[l.item as usize].model], title, label, help));
        }
    }
}

/// The same for links at masses of groups that have become modes: a force on one of them moves all of its group. Contacts beyond
/// [`STIFFEST`] too are solved as one of several would be, since that carries their energy instead of having it from places.
pub fn choose_modes(net: &mut Pruned) {
    let mut count: BTreeMap<String, u32> = BTreeMap::new();
    for l in net.lias.iter().filter(|l| !l.law.stage.is_explicit()) {
        for family in families(net, l) {
            *count.entry(family.into()).or_default() += 1;
        }
    }
    if count.is_empty() {
        return;
    }
    let (mats, bounds) = (worst_mats(net), worst_bounds(net));
    let mobility = |net: &Pruned, e: End| -> f64 {
        let c = |m: u32| mats[m as usize].c;
        let End::Point(p) = e else { return net.under(e).into_iter().map(c).sum() };
        let weights = net.points[p as usize].shape.iter().flat_map(|s| &s.0);
        net.under(e).into_iter().zip(weights).map(|(m, w)| w * w * c(m)).sum()
    };
    let all = net.lias.iter().zip(&bounds).map(|(l, b)| {
        let shares = families(net, l).any(|family| count.get(family).is_some_and(|n| *n > 1));
        let moves = || l.ends.into_iter().map(|e| mobility(net, e)).sum::<f64>();
        shares || b.contact && families(net, l).next().is_some() && b.k * moves() > STIFFEST
    });
    let all: Vec<bool> = all.collect();
    together(net, &all, |_| false);
    for l in &mut net.lias {
        if let SolveStage::Coupled(Some(at_modes)) = l.law.stage {
            if l.ends.into_iter().any(|e| matches!(e, End::Point(_))) {
                l.law = at_modes;
            }
        }
    }
}

/// Gives links that are `shared` the law that acts together.
fn together(net: &mut Pruned, shared: &[bool], on_line: impl Fn(&LiaNode) -> bool) {
    for (l, shared) in net.lias.iter_mut().zip(shared) {
        if let (SolveStage::Single(laws), true) = (l.law.stage, shared) {
            let [first, other] = if on_line(l) { [laws.line, laws.space] } else { [laws.space, laws.line] };
            l.law = first.or(other).unwrap_or(l.law);
        }
    }
}

/// The groups of the points that a link holds, end by end.
fn families<'n>(net: &'n Pruned, l: &LiaNode) -> impl Iterator<Item = &'n str> {
    l.ends.into_iter().filter_map(|e| if let End::Point(p) = e { Some(&*net.points[p as usize].family) } else { None })
}

/// The places that a link moves: MATs and axes.
fn places(net: &Pruned, l: &LiaNode) -> Vec<(u32, u8)> {
    let mut all = Vec::new();
    let second = l.onto.iter().map(|o| (o.ends, o.measure));
    for (ends, measure) in core::iter::once((l.ends, l.measure)).chain(second) {
        for (side, end) in ends.into_iter().enumerate() {
            let End::Mat(m) = end else { continue };
            let mat = &net.mats[m as usize];
            match measure {
                _ if mat.is_fixed() => {}
                Measure::Line(axes) => all.push((m, axes[side])),
                Measure::Along(_) | Measure::Radial => all.extend((0..mat.axes).map(|k| (m, k))),
            }
        }
    }
    all
}
