//! Two bounds of the largest eigenvalue from the sums, without a matrix (docs/numerics.md §1.3).

use crate::certify::accumulate::{Accumulated, Sums};
use crate::net::{End, Pruned};
use ca_core::Bound;

/// Result of the bounds; the limit is 4.
pub struct Bounds {
    /// Lower bound of the largest eigenvalue.
    pub lower: f64,
    /// MAT that gives the lower bound.
    pub cause: Option<usize>,
    /// Upper bound of the largest eigenvalue.
    pub upper: f64,
    /// MAT nearest to the limit, if any MAT has a link.
    pub worst: Option<usize>,
    /// True if all negative springs are covered by adjacent ones.
    pub covered: bool,
}

/// Bounds the largest eigenvalue from both sides.
pub fn bound(net: &Pruned, sums: &Accumulated) -> Bounds {
    let (mut lower, mut cause) = (0.0, None);
    for (i, s) in sums.mats.iter().enumerate() {
        if s.unsure {
            continue;
        }
        // The damper of a junction represents leaving waves, and returning waves may cancel it.
        let leaves = if net.lines.iter().any(|l| l.junctions().contains(&(i as u32))) { 2.0 * s.z } else { 0.0 };
        if (certain(s) - leaves) * s.scaled_mobility > lower {
            (lower, cause) = ((certain(s) - leaves) * s.scaled_mobility, Some(i));
        }
    }
    let negative = sums.links.iter().any(|b| b.k < 0.0);
    let discs = sums.mats.iter().map(|s| s.disc * s.scaled_mobility).fold(0.0, f64::max);
    let upper = if negative { discs } else { pairs(net, sums).min(discs) };
    let all = |i: &usize| sums.mats[*i].all * sums.mats[*i].scaled_mobility;
    let judged = (0..sums.mats.len()).filter(|i| all(i) > 0.0);
    let worst = judged.max_by(|a, b| all(a).total_cmp(&all(b)));
    Bounds { lower, cause, upper, worst, covered: !negative || sums.springs.covered() }
}

/// Returns the certain part of a sum: links of different directions add up to a third, or to the stiffest.
fn certain(s: &Sums) -> f64 {
    if s.radial { (s.certain / 3.0).max(s.most + s.negative) } else { s.certain }
}

/// Returns the largest sum over the ends of one link; own stiffness of a mass is a link to ground.
fn pairs(net: &Pruned, sums: &Accumulated) -> f64 {
    let one = |m: &u32| sums.mats[*m as usize].all * sums.mats[*m as usize].scaled_mobility;
    let alone = sums.mats.iter().map(|s| s.all * s.scaled_mobility).fold(0.0, f64::max);
    // The contacts of a set are judged by rule, and do not tie its members to each other.
    let tied = net.lias.iter().filter(|l| l.sets.is_none() && l.law.stage.is_explicit());
    let end = |e: End| net.reach(e).max(1.0) * net.under(e).iter().map(one).fold(0.0, f64::max);
    tied.map(|l| l.all_ends().map(end).sum()).fold(alone, f64::max)
}

/// Returns the explicit link that counts as much as this one.
pub(super) fn explicit(b: &Bound) -> Bound {
    let z = if b.centred { 0.0 } else { b.z };
    Bound { k: b.k - b.lift, z, lift: 0.0, centred: false, ..*b }
}
