//! The exact test of stability: H = M^-½ (T²K + 2TC) M^-½ has all eigenvalues below 4 exactly where the sparse Cholesky
//! factorisation of 4 − H succeeds (docs/numerics.md §1.3, eq. 1).
//!
//! Decides to scale by the roots of the masses first: the answer is the same, and mass ratios of many decades cost no
//! digits. The largest eigenvalue comes from the same test by bisection, not from an iteration that approaches it from
//! below: the answer is a bound on either side.

use crate::analysis::linear::{Linear, LinkRow};
use alloc::vec::Vec;
use faer::linalg::solvers::Solve as _;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// H of a network, ready to be tested against limits.
pub struct StabilityMatrix {
    /// lower half of H, its diagonal without gaps
    h: SparseColMat<u32, f64>,
    /// where the diagonal stands among the values
    diagonal: Vec<usize>,
    symbolic: SymbolicLlt<u32>,
    /// roots of the mobilities
    roots: Vec<f64>,
}

/// A factorisation of `limit − H`.
pub struct Factor {
    llt: Llt<u32, f64>,
    roots: Vec<f64>,
}

impl StabilityMatrix {
    /// The matrix of a network, each link as heavy as `weigh` says (1: as it is). `None` where nothing moves, or where
    /// there is no memory for it.
    pub fn new(linear: &Linear, weigh: impl Fn(&LinkRow) -> f64) -> Option<StabilityMatrix> {
        let n = linear.dofs.len();
        let roots: Vec<f64> = linear.dofs.iter().map(|p| libm::sqrt(p.c)).collect();
        let mut all = Vec::with_capacity(n + 3 * linear.rows.len());
        for (i, p) in linear.dofs.iter().enumerate() {
            all.push(Triplet::new(i as u32, i as u32, p.c * (p.k + 2.0 * p.z)));
        }
        for row in &linear.rows {
            let h = (row.k + 2.0 * row.z) * weigh(row);
            let entries = linear.entries(row);
            for (i, a) in entries {
                for (j, b) in entries.iter().filter(|(j, _)| j <= i) {
                    all.push(Triplet::new(*i, *j, h * a * roots[*i as usize] * (b * roots[*j as usize])));
                }
            }
        }
        if n == 0 || all.iter().any(|t| !t.val.is_finite()) {
            return None;
        }
        let h = SparseColMat::try_new_from_triplets(n, n, &all).ok()?;
        let symbolic = SymbolicLlt::try_new(h.symbolic(), Side::Lower).ok()?;
        let column = |j: usize| h.symbolic().col_range(j).find(|at| h.symbolic().row_idx()[*at] as usize == j);
        let diagonal: Option<Vec<usize>> = (0..n).map(column).collect();
        Some(StabilityMatrix { diagonal: diagonal?, symbolic, roots, h })
    }

    /// The factorisation of `limit − H`: there is one exactly where all eigenvalues are below the limit.
    pub fn below(&self, limit: f64) -> Option<Factor> {
        let mut s = self.h.clone();
        for v in s.val_mut() {
            *v = -*v;
        }
        for at in &self.diagonal {
            s.val_mut()[*at] += limit;
        }
        let llt = Llt::try_new_with_symbolic(self.symbolic.clone(), s.as_ref(), Side::Lower).ok()?;
        Some(Factor { llt, roots: self.roots.clone() })
    }

    /// Bounds of the largest eigenvalue, `digits` apart or nearer, from bounds that are known; 0 and 0 where no
    /// eigenvalue is positive.
    pub fn largest(&self, lower: f64, upper: f64, digits: f64) -> (f64, f64) {
        let (mut low, mut high) = (lower.max(0.0), upper.max(lower));
        // what was taken for a bound may be one of other dofs than those looked at
        if self.below(low).is_some() {
            (low, high) = (0.0, low);
        }
        while high < 1e300 && self.below(high).is_none() {
            (low, high) = (high, (2.0 * high).max(1e-300));
        }
        // masses that are free, beside links whose explicit part is negative
        if low == 0.0 && self.below(f64::MIN_POSITIVE).is_some() {
            return (0.0, 0.0);
        }
        while high - low > digits * high {
            // halves of the exponent while they are decades apart
            let middle =
                if low > 0.0 && high > 4.0 * low { libm::sqrt(low) * libm::sqrt(high) } else { 0.5 * (low + high) };
            if middle <= low || middle >= high {
                break;
            }
            if self.below(middle).is_some() { high = middle } else { low = middle }
        }
        (low, high)
    }
}

impl Factor {
    /// bᵀ (limit − H)⁻¹ b, with b scaled as H is.
    pub fn quadratic_form(&self, b: &[(u32, f64)]) -> f64 {
        let mut x = Mat::<f64>::zeros(self.roots.len(), 1);
        for (i, a) in b {
            x[(*i as usize, 0)] += a * self.roots[*i as usize];
        }
        self.llt.solve_in_place(&mut x);
        b.iter().map(|(i, a)| a * self.roots[*i as usize] * x[(*i as usize, 0)]).sum()
    }
}
