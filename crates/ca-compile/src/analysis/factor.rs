//! The exact test of stability (docs/numerics.md §1.3, eq. 1).
//!
//! H = M^-½ (T²K + 2TC) M^-½ has all eigenvalues below 4 if and only if the sparse Cholesky factorisation of 4 − H
//! exists. Scaling by the roots of the masses keeps the accuracy for mass ratios of many decades. The largest
//! eigenvalue is found by bisection with the same test, which bounds it on both sides; power iteration would approach
//! it only from below.

use crate::analysis::linear::{Linear, LinkRow};
use alloc::vec::Vec;
use faer::linalg::solvers::Solve as _;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};

/// H of a network, for tests against limits.
pub struct StabilityMatrix {
    /// Lower half of H, with a complete diagonal.
    h: SparseColMat<u32, f64>,
    /// Positions of the diagonal among the values.
    diagonal: Vec<usize>,
    symbolic: SymbolicLlt<u32>,
    /// Square roots of the mobilities.
    roots: Vec<f64>,
}

/// A factorisation of `limit − H`.
pub struct Factor {
    llt: Llt<u32, f64>,
    roots: Vec<f64>,
}

impl StabilityMatrix {
    /// Builds the matrix of a network, with each link multiplied by `weigh`. Returns `None` if nothing moves, if a
    /// number is not finite, or without enough memory.
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

    /// Returns the factorisation of `limit − H`, which exists if and only if all eigenvalues are below the limit.
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

    /// Returns bounds of the largest eigenvalue with a relative distance of at most `digits`, starting from known
    /// bounds. Both are 0 if no eigenvalue is positive.
    pub fn largest(&self, lower: f64, upper: f64, digits: f64) -> (f64, f64) {
        let (mut low, mut high) = (lower.max(0.0), upper.max(lower));
        // The known bounds may include dofs outside this matrix.
        if self.below(low).is_some() {
            (low, high) = (0.0, low);
        }
        while high < 1e300 && self.below(high).is_none() {
            (low, high) = (high, (2.0 * high).max(1e-300));
        }
        // Free masses, beside links whose explicit part is negative.
        if low == 0.0 && self.below(f64::MIN_POSITIVE).is_some() {
            return (0.0, 0.0);
        }
        while high - low > digits * high {
            // Bisect the exponent while the bounds are far apart.
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
    /// Returns bᵀ (limit − H)⁻¹ b, with b scaled as H is.
    pub fn quadratic_form(&self, b: &[(u32, f64)]) -> f64 {
        let mut x = Mat::<f64>::zeros(self.roots.len(), 1);
        for (i, a) in b {
            x[(*i as usize, 0)] += a * self.roots[*i as usize];
        }
        self.llt.solve_in_place(&mut x);
        b.iter().map(|(i, a)| a * self.roots[*i as usize] * x[(*i as usize, 0)]).sum()
    }
}
