//! Indices of the numbers of linear links, and slots of their ends.

use crate::parts::Basis;
use ca_core::Scene;
use ca_core::internal::op::{Band, Op};
use ca_core::internal::state::Fold;

pub struct Rows {
    pub basis: Basis,
    /// Runs of links: count, and the two end slots of the first; empty where ends are looked up.
    pub runs: Vec<(usize, [usize; 2])>,
    /// Slots of the ends of links outside runs.
    pub ends: Vec<[u32; 2]>,
    /// Index of the first coefficient, and of the first constant elongation.
    pub coef: usize,
    pub first: usize,
    pub n: usize,
}

impl Rows {
    /// Returns the links of a pass that sums forces.
    pub fn listed(scene: &Scene, op: &Op, basis: &Basis) -> Rows {
        let (runs, ends) = match op.form.stride {
            0 => (Vec::new(), scene.layout.links.ends[op.first..][..op.n].to_vec()),
            stride => (vec![(op.n, [op.mat, op.mat + stride])], Vec::new()),
        };
        Rows { basis: basis.clone(), runs, ends, coef: op.coef, first: op.first, n: op.n }
    }

    pub fn slots(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let in_runs = self.runs.iter().flat_map(|(n, [a, b])| (0..*n).map(move |i| [a + i, b + i]));
        in_runs.chain(self.ends.iter().map(|ends| ends.map(|m| m as usize)))
    }

    /// Returns the links of a pass that integrates, along it and across.
    pub fn integrated(op: &Op, basis: &Basis) -> Vec<Rows> {
        let (n, at, coefs) = (op.n, op.mat, basis.0.len());
        let row = |runs, (coef, first)| Rows { basis: basis.clone(), runs, ends: Vec::new(), coef, first, n };
        if !op.form.folded {
            return vec![row(vec![(n, [at, at + 1])], (op.coef, op.first))];
        }
        // neighbours of the last vectors are at the beginning, one lane on; the last lane has none after it
        let folded = |step: usize, numbers: (usize, usize)| {
            row(vec![(n - step, [at, at + step]), (step, [at + n - step, at + 1])], numbers)
        };
        let along = folded(Fold::LANES, (op.coef, op.first));
        let Band::Along(width) = op.form.band else { return vec![along] };
        vec![along, folded(width * Fold::LANES, (op.coef + coefs * n, op.first + n))]
    }
}
