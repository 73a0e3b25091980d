//! Normal equations of a few unknowns, solved by eigenvectors.
//!
//! Eigenvectors of the scaled matrix serve better than a factorisation here: there are at most a dozen unknowns, each
//! damping is one division per eigenvalue, and flat directions are found instead of failing.

use faer::{Mat, Side};

/// Curvature, relative to the largest, below which only rounding of differences is left.
const FLAT: f64 = 1e-10;
/// Least component of a flat direction along an unknown that makes the unknown undetermined.
const SHARE: f64 = 0.1;

pub(super) struct Normal {
    /// Roots of the diagonal.
    scale: Vec<f64>,
    vectors: Vec<Vec<f64>>,
    values: Vec<f64>,
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

impl Normal {
    /// Makes them from columns; `None` where a value is not finite.
    pub fn of(columns: &[Vec<f64>]) -> Option<Normal> {
        let n = columns.len();
        let scale: Vec<f64> = columns.iter().map(|c| libm::sqrt(dot(c, c))).collect();
        if scale.iter().any(|s| !s.is_finite()) {
            return None;
        }
        if n == 0 {
            return Some(Normal { scale, vectors: Vec::new(), values: Vec::new() });
        }
        let unit = |k: usize| if scale[k] > 0.0 { 1.0 / scale[k] } else { 0.0 };
        let a = Mat::from_fn(n, n, |i, j| dot(&columns[i], &columns[j]) * unit(i) * unit(j));
        let found = a.self_adjoint_eigen(Side::Lower).ok()?;
        let (u, s) = (found.U(), found.S());
        let vectors = (0..n).map(|j| (0..n).map(|i| u[(i, j)]).collect()).collect();
        Some(Normal { vectors, values: (0..n).map(|j| s[j]).collect(), scale })
    }

    fn flat(&self, j: usize) -> bool {
        self.values[j] <= FLAT * self.values.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the step against a gradient; `damping` is relative to the curvature of each unknown.
    pub fn step(&self, gradient: &[f64], damping: f64) -> Vec<f64> {
        let n = self.scale.len();
        let mut x = vec![0.0; n];
        let part = |k: usize| if self.scale[k] > 0.0 { 1.0 / self.scale[k] } else { 0.0 };
        let scaled: Vec<f64> = (0..n).map(|k| gradient[k] * part(k)).collect();
        for j in (0..n).filter(|j| !self.flat(*j)) {
            let along = dot(&self.vectors[j], &scaled) / (self.values[j] + damping);
            for (k, to) in x.iter_mut().enumerate() {
                *to -= along * self.vectors[j][k] * part(k);
            }
        }
        x
    }

    /// Returns the variances of the unknowns; `None` where one is not determined. `sums` holds, for each stretch of
    /// time, the products of residuals and columns: residuals of a recording are correlated, and treating them as
    /// independent would give too small a variance. At least the variance for independent residuals is returned.
    pub fn variances(&self, sums: &[Vec<f64>], variance: f64) -> Vec<Option<f64>> {
        let n = self.scale.len();
        let inverse = |b: &[f64]| self.step(b, 0.0);
        let stretches = sums.len() as f64;
        let correction = if stretches > 1.0 { stretches / (stretches - 1.0) } else { 1.0 };
        let moved: Vec<Vec<f64>> = sums.iter().map(|s| inverse(s)).collect();
        (0..n)
            .map(|k| {
                let flat = |j: usize| self.flat(j) && self.vectors[j][k].abs() > SHARE;
                if self.scale[k] == 0.0 || (0..n).any(flat) {
                    return None;
                }
                let unit: Vec<f64> = (0..n).map(|i| f64::from(i == k)).collect();
                let alone = -inverse(&unit)[k] * variance;
                let together = correction * moved.iter().map(|m| m[k] * m[k]).sum::<f64>();
                Some(alone.max(together))
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_solves_the_equations_and_skips_what_is_flat() {
        let columns = vec![vec![1.0, 0.0, 2.0], vec![0.0, 3.0, 1.0]];
        let normal = Normal::of(&columns).unwrap();
        let r = [1.0, -2.0, 0.5];
        let gradient: Vec<f64> = columns.iter().map(|c| dot(c, &r)).collect();
        let x = normal.step(&gradient, 0.0);
        let left: Vec<f64> = (0..3).map(|i| r[i] + columns[0][i] * x[0] + columns[1][i] * x[1]).collect();
        assert!(columns.iter().all(|c| dot(c, &left).abs() < 1e-12));
        // two equal columns and a zero column: none is determined
        let columns = vec![vec![1.0, 2.0], vec![2.0, 4.0], vec![0.0, 0.0]];
        let normal = Normal::of(&columns).unwrap();
        assert!(normal.step(&[1.0, 2.0, 0.0], 0.0).iter().all(|x| x.is_finite()));
        assert_eq!(normal.variances(&[vec![0.0; 3]], 1.0), [None, None, None]);
        assert!(Normal::of(&[]).unwrap().step(&[], 0.0).is_empty());
    }
}
