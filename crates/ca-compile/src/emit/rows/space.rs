//! Rows in space: links of a batch between consecutive points, e.g. along and across a cloth.
//!
//! Rows are found in the existing order of the links, which is the order of sums, and stay in their batch: a pass for
//! each row of a cloth would have the overhead of twenty passes.

use alloc::vec::Vec;
use ca_core::internal::op::{MeasureKind, Op};

/// Shortest row; shorter ones are looked up.
pub const SHORTEST: usize = 4;

/// Slots of a point.
pub const POINT: u32 = 3;

/// Returns [`LinkArrays::rows`](ca_core::internal::op::layout::LinkArrays::rows) for the links of `forces`.
pub fn rows(forces: &[Op], ends: &[[u32; 2]], reach: &[[f64; 4]], rest: &[f64]) -> Vec<i32> {
    let mut rows = alloc::vec![-1; reach.len()];
    for op in forces.iter().filter(|op| op.ports.measure == MeasureKind::Radial && op.ports.onto.is_none()) {
        if op.ports.pair_set.is_some() {
            continue;
        }
        let (ends, at) = (&ends[op.first..][..op.n], op.ports.reach);
        let apart = |i: usize| {
            let [a, b] = ends[i].map(|m| m as usize);
            a < b && (0..3).all(|k| rest[b + k] - rest[a + k] == reach[at + i][k])
        };
        let follows = |i: usize| ends[i] == ends[i - 1].map(|m| m + POINT) && apart(i - 1) && apart(i);
        let mut first = 0;
        while first < op.n {
            let next = (first + 1..op.n).find(|i| !follows(*i)).unwrap_or(op.n);
            let links = next - first;
            for (k, row) in rows[at + first..at + next].iter_mut().enumerate() {
                *row = if links < SHORTEST { -1 } else { (links - k) as i32 };
            }
            first = next;
        }
        // Links that are looked up form stretches.
        for i in (at..(at + op.n).saturating_sub(1)).rev() {
            if rows[i] < 0 && rows[i + 1] < 0 {
                rows[i] = rows[i + 1] - 1;
            }
        }
    }
    rows
}
