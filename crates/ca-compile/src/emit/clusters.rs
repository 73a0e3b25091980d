//! Clusters: the links solved together that share masses, directly or through others.
//!
//! The pushes of one cluster do not move the masses of another, so each is solved by itself, and ends as soon as it has
//! converged. Links share no mass through a fixed end or a port, since these have no mobility.

use crate::net::disjoint::Sets;
use alloc::vec::Vec;
use ca_core::internal::op::layout::MeasureKind;
use ca_core::internal::op::{Op, SolveStage};

/// Returns the cluster of each link, or an empty list if there is only one. `ends` has the first slots of the ends of
/// each link, `mobility` the mobility of each slot.
pub fn clusters(passes: &[Op], ends: &[[u32; 2]], mobility: &[f64]) -> Vec<u32> {
    let mut sets = Sets::new(mobility.len());
    let coupled = passes.iter().filter(|op| op.law.is_some_and(|law| matches!(law.stage, SolveStage::Coupled(_))));
    let links: Vec<(usize, usize)> = coupled
        .flat_map(|op| {
            let axes = if op.form.measure == MeasureKind::Line { 1 } else { 3 };
            (op.first..op.first + op.n).map(move |link| (link, axes))
        })
        .collect();
    let slots = |(link, axes): (usize, usize)| {
        let moves = |slot: &usize| mobility[*slot] != 0.0;
        ends[link].into_iter().flat_map(move |end| end as usize..end as usize + axes).filter(moves)
    };
    for link in &links {
        let mut all = slots(*link);
        if let Some(first) = all.next() {
            all.for_each(|slot| sets.join(first, slot));
        }
    }
    let mut of = alloc::vec![u32::MAX; ends.len()];
    let mut number = alloc::vec![u32::MAX; mobility.len()];
    let mut next = 0;
    for link in &links {
        // a link without a slot that moves is a cluster of its own
        let root = slots(*link).next().map(|slot| sets.root(slot));
        let known = root.map_or(u32::MAX, |root| number[root]);
        of[link.0] = if known == u32::MAX { next } else { known };
        if known == u32::MAX {
            next += 1;
        }
        if let Some(root) = root {
            number[root] = of[link.0];
        }
    }
    if next > 1 { of } else { Vec::new() }
}
