//! Reach: marks MATs that receive the motion of a body in space as a whole.
//!
//! A quadripole transmits any change of a distance in space to its line port, including the slow stretch of a spinning
//! body (docs/numerics.md §4.3), and so to everything linked to that port. Outputs there have a high-pass unless one is
//! written (see `emit/high_pass.rs`).

use crate::net::{End, Measure, OutNode, OutputTap, Pruned};
use alloc::vec::Vec;

/// Marks the MATs linked to the line port of a quadripole whose other port is in space.
pub fn mark(net: &mut Pruned) {
    let line = |m: Measure| matches!(m, Measure::Line(_));
    let second = |l: &crate::net::LiaNode| {
        l.onto.as_deref().copied().filter(|o| l.measure == Measure::Radial && line(o.measure))
    };
    let seeds: Vec<End> = net.lias.iter().filter_map(second).flat_map(|o| o.ends).collect();
    if seeds.is_empty() {
        return;
    }
    // Links that transmit motion between MATs: links on lines, and line ports.
    let mut at: Vec<Vec<u32>> = alloc::vec![Vec::new(); net.mats.len()];
    let mut joins: Vec<Vec<u32>> = Vec::new();
    let moving = |ends: &[End]| -> Vec<u32> {
        let all = ends.iter().flat_map(|e| net.under(*e));
        all.filter(|m| !net.mats[*m as usize].is_fixed()).collect()
    };
    for l in &net.lias {
        let first = if line(l.measure) { moving(&l.ends) } else { Vec::new() };
        let other = l.onto.as_ref().filter(|o| line(o.measure)).map_or(Vec::new(), |o| moving(&o.ends));
        let all: Vec<u32> = first.into_iter().chain(other).collect();
        for m in &all {
            at[*m as usize].push(joins.len() as u32);
        }
        joins.push(all);
    }
    let mut from_lpr = alloc::vec![false; net.mats.len()];
    let mut reached = moving(&seeds);
    while let Some(m) = reached.pop() {
        if core::mem::replace(&mut from_lpr[m as usize], true) {
            continue;
        }
        for j in core::mem::take(&mut at[m as usize]) {
            reached.append(&mut joins[j as usize]);
        }
    }
    net.from_lpr = from_lpr;
}

impl Pruned {
    /// Returns whether an output reads a MAT that hangs on the line port of a quadripole.
    pub fn reads_lpr(&self, out: &OutNode) -> bool {
        let reached = |m: u32| self.from_lpr.get(m as usize).copied().unwrap_or(false);
        if self.from_lpr.is_empty() {
            return false;
        }
        match out.tap {
            OutputTap::Position(e) | OutputTap::ForceOn(e) => self.under(e).into_iter().any(reached),
            OutputTap::ForceOf(l) => self.lias[l as usize].all_ends().any(|e| self.under(e).into_iter().any(reached)),
        }
    }
}
