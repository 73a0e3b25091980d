//! Fold: long rows that integrate their masses stand in eight stretches side by side ([`Fold`]).
//!
//! Decides this when all else of the masses is known and nothing has been laid out by their slots: what comes later sees
//! slots only, and needs to know nothing of it. Only where a vector of eight is wide in numbers of the tick: in single
//! precision rows run as they stand.

use crate::emit::batches::Batch;
use crate::emit::plan::Plan;
use crate::emit::schedule::Masses;
use alloc::vec::Vec;
use ca_core::op::Integrate;
use ca_core::real::Real;
use ca_core::state::Fold;

/// Rows of fewer links run as they stand. Folded, a string of 24 masses takes 31 ns where it took 47; shorter ones were not
/// measured, and what crosses lanes is a larger part of them.
const SHORTEST: usize = 16;

/// Folds the rows that are worth it; returns where each slot went, nothing where none is folded.
pub fn fold(plan: &mut Plan, masses: &mut Masses, batches: &mut [Batch]) -> Vec<u32> {
    let mut folds: Vec<Fold> = Vec::new();
    if size_of::<Real>() != size_of::<f64>() {
        return Vec::new();
    }
    for row in batches.iter_mut() {
        let n = row.links.len();
        if row.integrate == Integrate::No || !row.law.wide || n < SHORTEST {
            continue;
        }
        let within = Fold { first: 0, rows: (n / Fold::LANES) as u32 };
        folds.push(Fold { first: plan.ends(row.links[0])[0], ..within });
        let written = row.links.clone();
        for (i, l) in written[..n / Fold::LANES * Fold::LANES].iter().enumerate() {
            row.links[within.at(i)] = *l;
        }
        (row.stride, row.folded) = (0, true);
    }
    if folds.is_empty() {
        return Vec::new();
    }
    let n_mat = plan.coef_slots();
    let mut to: Vec<u32> = (0..n_mat as u32).collect();
    for f in &folds {
        for i in 0..f.rows as usize * Fold::LANES {
            to[f.first as usize + i] = f.at(i) as u32;
        }
    }
    for slot in plan.slot.iter_mut().filter(|s| **s != u32::MAX) {
        *slot = to[*slot as usize];
    }
    let coefs = plan.coef.chunks_exact_mut(n_mat);
    for all in coefs.chain([&mut masses.x[..], &mut masses.v, &mut masses.rest]) {
        let written = all.to_vec();
        for (v, to) in written.iter().zip(&to) {
            all[*to as usize] = *v;
        }
    }
    for coef in &mut plan.live {
        let (column, slot) = (*coef as usize / n_mat, *coef as usize % n_mat);
        *coef = (column * n_mat) as u32 + to[slot];
    }
    to
}
