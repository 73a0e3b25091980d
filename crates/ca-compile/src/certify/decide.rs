//! Decide: stable, unstable or neither, from the bounds, and by a factorisation where they leave it open or somebody asks.

use crate::certify::accumulate::Accumulated;
use crate::certify::bound::Bounds;
use crate::certify::exact::{self, Exact};
use crate::certify::rules::{creeps, rubs};
use crate::net::{LiaNode, Pruned};
use crate::options::Effort;
use ca_core::internal::scene::certificate::FactorVerdict;
use ca_core::{Bound, Level};

/// What is known.
pub struct Decision {
    /// how sure
    pub level: Level,
    /// what the factorisation says, where there is one
    pub verdict: FactorVerdict,
    /// the factorisation
    pub exact: Option<Exact>,
    /// whether it is worth asking it about each contact: they are few for its size
    pub few: bool,
}

/// Decides.
pub fn decide(net: &Pruned, sums: &Accumulated, bounds: &Bounds, effort: Effort) -> Decision {
    let spots = |l: &LiaNode| l.ends.iter().map(|e| net.spots(*e)).product::<usize>();
    let touching = net.lias.iter().zip(&sums.links).filter(|(l, b)| by_rule(net, sums, l, b));
    let touching: usize = touching.map(|(l, _)| spots(l)).sum();
    let few = effort != Effort::Bounds && touching > 0 && touching.saturating_mul(sums.mats.len()) <= exact::WORK;
    let open = bounds.lower < 4.0 && bounds.upper >= 4.0 && bounds.covered;
    let open = open && effort != Effort::Bounds;
    let exact = if open || few || effort == Effort::Largest { Exact::new(net, &sums.mats, &sums.links) } else { None };
    let verdict = exact.as_ref().filter(|_| open).map_or(FactorVerdict::Open, |e| e.verdict(net, &sums.links));
    // waves may hold what the matrix, which has none, does not
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
    if !explicit.clone().all(|(_, b)| b.linear) || net.lias.iter().any(|l| creeps(net, l)) {
        Level::RuleOfThumb
    } else if explicit.any(|(l, _)| l.is_radial()) {
        Level::Linearised
    } else {
        Level::Proven
    }
}

/// A contact or a friction along a curve that holds something held elsewhere too.
fn by_rule(net: &Pruned, sums: &Accumulated, l: &LiaNode, b: &Bound) -> bool {
    let held = || l.all_ends().flat_map(|e| net.under(e)).any(|m| sums.mats[m as usize].all > 0.0);
    ((b.contact && (b.k > 0.0 || b.power.0 > 0.0)) || rubs(b))
        && l.sets.is_none()
        && l.law.stage.is_explicit()
        && held()
}
