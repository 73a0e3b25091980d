//! Bound: two bounds of the largest eigenvalue from the sums, without a matrix (docs/numerics.md §1.3).

use crate::certify::accumulate::{Accumulated, Sums};
use crate::net::{End, Pruned};
use ca_core::Bound;

/// What the sums say; the limit is 4.
pub struct Bounds {
    /// the largest eigenvalue is at least this
    pub lower: f64,
    /// the MAT that makes it so
    pub cause: Option<usize>,
    /// it is at most this
    pub upper: f64,
    /// the MAT nearest to the limit, if one has any
    pub worst: Option<usize>,
    /// whether each negative spring is covered by those beside it
    pub covered: bool,
}

/// Bounds the largest eigenvalue from both sides.
pub fn bound(net: &Pruned, sums: &Accumulated) -> Bounds {
    let (mut lower, mut cause) = (0.0, None);
    for (i, s) in sums.mats.iter().enumerate() {
        // waves that come back may hold a junction against its own damper, which is where they leave
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

/// Springs of different directions do not add up: a third of them does, and so does the stiffest.
fn certain(s: &Sums) -> f64 {
    if s.radial { (s.certain / 3.0).max(s.most + s.negative) } else { s.certain }
}

/// The largest sum over the ends of one link; a mass with a spring of its own is a link to the ground.
fn pairs(net: &Pruned, sums: &Accumulated) -> f64 {
    let one = |m: &u32| sums.mats[*m as usize].all * sums.mats[*m as usize].scaled_mobility;
    let alone = sums.mats.iter().map(|s| s.all * s.scaled_mobility).fold(0.0, f64::max);
    // the contacts of a set are judged by rule, and no two of its members are tied
    let tied = net.lias.iter().filter(|l| l.sets.is_none() && l.law.stage.is_explicit());
    let end = |e: End| net.reach(e).max(1.0) * net.under(e).iter().map(one).fold(0.0, f64::max);
    tied.map(|l| l.all_ends().map(end).sum()).fold(alone, f64::max)
}

/// The explicit link that counts as much as this one.
pub(super) fn explicit(b: &Bound) -> Bound {
    let z = if b.centred { 0.0 } else { b.z };
    Bound { k: b.k - b.lift, z, lift: 0.0, centred: false, ..*b }
}
