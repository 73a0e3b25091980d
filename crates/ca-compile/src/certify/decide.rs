//! Stable, unstable or not proven: decided from the bounds, or by a factorisation if they are open or it is requested.

use crate::certify::accumulate::Accumulated;
use crate::certify::bound::Bounds;
use crate::certify::exact::{self, Exact};
use crate::certify::rules::{creeps, rounds, rubs};
use crate::net::{LiaNode, Pruned};
use crate::options::Effort;
use ca_core::internal::scene::certificate::FactorVerdict;
use ca_core::{Bound, Level};

/// Result of `decide`.
pub struct Decision {
    /// Level of certainty.
    pub level: Level,
    /// Result of the factorisation, if it was needed.
    pub verdict: FactorVerdict,
    /// The factorisation.
    pub exact: Option<Exact>,
    /// True if contacts are few enough to evaluate each by the factorisation.
    pub few: bool,
}

/// Returns the level of stability, with the factorisation if one was made.
pub fn decide(net: &Pruned, sums: &Accumulated, bounds: &Bounds, effort: Effort) -> Decision {
    let spots = |l: &LiaNode| l.ends.iter().map(|e| net.spots(*e)).product::<usize>();
    let touching = net.lias.iter().zip(&sums.links).filter(|(l, b)| by_rule(net, sums, l, b));
    let touching: usize = touching.map(|(l, _)| spots(l)).sum();
    let few = effort != Effort::Bounds && touching > 0 && touching.saturating_mul(sums.mats.len()) <= exact::WORK;
    let open = bounds.lower < 4.0 && bounds.upper >= 4.0 && bounds.covered;
    let open = open && effort != Effort::Bounds;
    let exact = if open || few || effort == Effort::Largest { Exact::new(net, &sums.mats, &sums.links) } else { None };
    let verdict = exact.as_ref().filter(|_| open).map_or(FactorVerdict::Open, |e| e.verdict(net, sums));
    // Waves may stabilise a scene that is unstable by the matrix, which does not contain them.
    let verdict =
        if verdict == FactorVerdict::Unstable && !net.lines.is_empty() { FactorVerdict::Open } else { verdict };
    Decision { level: level(net, sums, bounds, verdict), verdict, exact, few }
}

fn level(net: &Pruned, sums: &Accumulated, bounds: &Bounds, verdict: FactorVerdict) -> Level {
    if bounds.lower >= 4.0 || verdict == FactorVerdict::Unstable {
        return Level::Unstable;
    }
    if !(bounds.upper < 4.0 || verdict == FactorVerdict::Stable) || !bounds.covered {
        return Level::NotProven;
    }
    let mut explicit = net.lias.iter().zip(&sums.links).filter(|(l, _)| l.law.stage.is_explicit());
    let beyond = |(l, b)| creeps(net, l) || rounds(net, sums, l, b).is_some();
    if !explicit.clone().all(|(_, b)| b.linear) || net.lias.iter().zip(&sums.links).any(beyond) {
        Level::RuleOfThumb
    } else if explicit.any(|(l, _)| l.is_radial()) {
        Level::Linearised
    } else {
        Level::Proven
    }
}

/// Returns whether a contact, or friction along a curve, acts on a MAT that other links hold too.
fn by_rule(net: &Pruned, sums: &Accumulated, l: &LiaNode, b: &Bound) -> bool {
    let held = || l.all_ends().flat_map(|e| net.under(e)).any(|m| sums.mats[m as usize].all > 0.0);
    ((b.contact && (b.k > 0.0 || b.power.0 > 0.0)) || rubs(b))
        && l.sets.is_none()
        && l.law.stage.is_explicit()
        && held()
}
