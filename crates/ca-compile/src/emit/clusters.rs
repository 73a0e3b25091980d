//! Clusters: the links solved together that share masses, directly or through others.
//!
//! The pushes of one cluster do not move the masses of another, so each is solved by itself, and ends as soon as it has
//! converged. A fixed end or a port does not join clusters, since its mobility is 0.

use crate::net::disjoint::Sets;
use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use ca_core::internal::op::layout::{LinkArrays, MeasureKind};
use ca_core::internal::op::{Op, SolveStage};

/// Returns the cluster of each link, or an empty list if there is only one. `mobility` has the mobility of each slot.
pub fn clusters(passes: &[Op], arrays: &LinkArrays, mobility: &[f64]) -> Vec<u32> {
    let coupled = passes.iter().filter(|op| op.law.is_some_and(|law| matches!(law.stage, SolveStage::Coupled(_))));
    let links: Vec<(usize, Vec<usize>)> =
        coupled.flat_map(|op| (0..op.n).map(|i| (op.first + i, slots(op, i, arrays, mobility)))).collect();
    let mut sets = Sets::new(mobility.len());
    for (_, slots) in &links {
        slots.windows(2).for_each(|pair| sets.join(pair[0], pair[1]));
    }
    let mut of = alloc::vec![u32::MAX; arrays.ends.len()];
    let mut numbers = BTreeMap::new();
    let mut next = 0;
    for (link, slots) in &links {
        let new = next;
        let mut number = || {
            next += 1;
            new
        };
        // a link whose ends do not move is a cluster
        of[*link] = match slots.first() {
            Some(slot) => *numbers.entry(sets.root(*slot)).or_insert_with(number),
            None => number(),
        };
    }
    if next > 1 { of } else { Vec::new() }
}

/// Returns the slots that link `i` of a pass moves.
fn slots(op: &Op, i: usize, arrays: &LinkArrays, mobility: &[f64]) -> Vec<usize> {
    let second = op.ports.onto.map(|(measure, first, _)| (measure, arrays.onto[first + i]));
    let ports = core::iter::once((op.form.measure, arrays.ends[op.first + i])).chain(second);
    let all = ports.flat_map(|(measure, ends)| {
        let axes = if measure == MeasureKind::Line { 1 } else { 3 };
        ends.into_iter().flat_map(move |end| end as usize..end as usize + axes)
    });
    all.filter(|slot| mobility[*slot] != 0.0).collect()
}
