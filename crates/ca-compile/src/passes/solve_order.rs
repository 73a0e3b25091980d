//! Solve order: which implicit links are solved alone, and which together.
//!
//! A link that uses the motion due to all other forces is correct only if no other such link changes this motion. The
//! pass counts such links at every axis that moves. Contacts between separate pairs keep their closed forms; only those
//! that share a mass or a modal group need a solver.

use crate::net::worst::{worst_bounds, worst_mats};
use crate::net::{End, LiaNode, Measure, Pruned};
use crate::options::Options;
use crate::passes::auto::Refusals;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::internal::op::{Coupled, SolveStage};
use ca_model::Model;
use ca_model::diag::Diags;

/// Largest kT²/m of a contact in closed form at a modal mass. Beyond it the error of the depth, a difference of two
/// rounded positions, times k is more than 1e-13 of the energy (docs/numerics.md §3.3).
const STIFFEST: f64 = 1e3;

/// Sets the law for links that must be solved together. Refuses such links at moving points, which move several masses.
pub fn choose(model: &Model, net: &mut Pruned, options: &Options, diags: &mut Diags) {
    let mut count: Vec<[u32; 3]> = alloc::vec![[0; 3]; net.mats.len()];
    let mut refusals = Refusals::begin(model, net);
    for l in net.lias.iter().filter(|l| !l.law.stage.is_explicit()) {
        if let Some(point) = l.all_ends().find(|e| matches!(e, End::Point(_))) {
            let title =
                format!("the method of `{}` does not work at a moving point, `{}`", l.name, net.end_name(point));
            let help = "use `method = \"ca\"`, or replace the point by a mass such as `low[8]`";
            refusals.refuse(&net.items, l.item, (title, "not at moving points", help), diags);
        }
        for (m, axis) in places(net, l) {
            count[m as usize][axis as usize] += 1;
        }
    }
    let twice = |l: &LiaNode| places(net, l).into_iter().find(|(m, k)| count[*m as usize][*k as usize] > 1);
    for l in net.lias.iter().filter(|l| matches!(l.law.stage, SolveStage::Single(_)) && l.onto.is_some()) {
        // Set-valued friction of four ends is not solved together with other links.
        if let Some((m, _)) = twice(l) {
            let title = format!(
                "`{}` shares `{}` with another link that is solved implicitly",
                l.name, net.mats[m as usize].name
            );
            let help = "use `method = \"ca\"` for one of them";
            refusals.refuse(&net.items, l.item, (title, "not together with others", help), diags);
        }
    }
    let shared = |l: &LiaNode| !matches!(l.measure, Measure::Line(_)) || twice(l).is_some();
    let shared: Vec<bool> = net.lias.iter().map(|l| !l.law.stage.is_explicit() && shared(l)).collect();
    refuse_shared(net, &shared, &mut refusals, diags);
    // Friction at shared masses is solved with the method of §3.4, whose system is linear like its own.
    let rubs = |(l, shared): (&LiaNode, &bool)| *shared && !l.law.contact && !on_lines_alone(l);
    let curves = options.is_since(6) && !net.lias.iter().zip(&shared).any(rubs);
    together(net, &shared, |l| curves && !matches!(l.measure, Measure::Radial));
    refusals.end(net);
}

/// Returns whether the method of a law works on lines only.
fn on_lines_alone(l: &LiaNode) -> bool {
    matches!(l.law.stage, SolveStage::Single(laws) if laws.space.is_none())
}

/// Refuses laws whose method works on lines only: in space, and at shared masses if their force falls, since a step may
/// then have several solutions.
fn refuse_shared(net: &Pruned, shared: &[bool], refusals: &mut Refusals<'_>, diags: &mut Diags) {
    let links = || net.lias.iter().zip(shared).zip(0usize..).filter(|((l, shared), _)| **shared && on_lines_alone(l));
    if links().next().is_none() {
        return;
    }
    let bounds = worst_bounds(net);
    for ((l, _), i) in links() {
        let SolveStage::Single(laws) = l.law.stage else { continue };
        let (title, label, help) = if l.measure == Measure::Radial {
            let title = format!("the method of `{}` is only for links on a line", l.name);
            (title, "in space", "use `method = \"ca\"`, or `along` for a difference along one direction")
        } else if laws.line.is_none() || bounds[i].active {
            let title =
                format!("the force of `{}` falls, and other links that are solved implicitly move its masses", l.name);
            (title, "not together with others", "use `method = \"ca\"` for this link")
        } else {
            continue;
        };
        refusals.refuse(&net.items, l.item, (title, label, help), diags);
    }
}

/// Sets the laws of links at modal masses, where a force on one mass moves the whole group.
///
/// Contacts beyond [`STIFFEST`] use the law for several links too, because it carries their energy in a variable
/// instead of computing it from positions.
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
        if let SolveStage::Coupled(Coupled { at_modes: Some(at_modes), .. }) = l.law.stage {
            if l.ends.into_iter().any(|e| matches!(e, End::Point(_))) {
                l.law = at_modes;
            }
        }
    }
}

/// Sets the law for solving together for all `shared` links.
fn together(net: &mut Pruned, shared: &[bool], on_line: impl Fn(&LiaNode) -> bool) {
    for (l, shared) in net.lias.iter_mut().zip(shared) {
        if let (SolveStage::Single(laws), true) = (l.law.stage, shared) {
            let [first, other] = if on_line(l) { [laws.line, laws.space] } else { [laws.space, laws.line] };
            l.law = first.or(other).unwrap_or(l.law);
        }
    }
}

fn families<'n>(net: &'n Pruned, l: &LiaNode) -> impl Iterator<Item = &'n str> {
    l.ends.into_iter().filter_map(|e| if let End::Point(p) = e { Some(&*net.points[p as usize].family) } else { None })
}

/// Returns the MATs and axes that a link moves.
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
