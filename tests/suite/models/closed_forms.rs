//! Closed forms of modes.

use std::f64::consts::PI;

pub fn sin2(j: usize, n: usize) -> f64 {
    (j as f64 * PI / (2.0 * n as f64)).sin().powi(2)
}

/// Eigenvalues of a symmetric matrix in rising order, by Jacobi rotations.
pub fn eigenvalues(mut m: Vec<Vec<f64>>) -> Vec<f64> {
    let n = m.len();
    for _ in 0..60 {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| m[i][j] * m[i][j]).sum();
        if off < 1e-30 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if m[p][q] == 0.0 {
                    continue;
                }
                let tau = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
                let c = 1.0 / (1.0 + t * t).sqrt();
                let s = t * c;
                for row in &mut m {
                    let (a, b) = (row[p], row[q]);
                    (row[p], row[q]) = (c * a - s * b, s * a + c * b);
                }
                let (upper, lower) = m.split_at_mut(q);
                for (a, b) in upper[p].iter_mut().zip(&mut lower[0]) {
                    (*a, *b) = (c * *a - s * *b, s * *a + c * *b);
                }
            }
        }
    }
    let mut v: Vec<f64> = (0..n).map(|i| m[i][i]).collect();
    v.sort_by(f64::total_cmp);
    v
}

#[test]
fn eigenvalues_are_those_of_a_chain() {
    let e = eigenvalues(vec![vec![2.0, -1.0, 0.0], vec![-1.0, 2.0, -1.0], vec![0.0, -1.0, 2.0]]);
    assert!((e[0] - (2.0 - 2f64.sqrt())).abs() < 1e-12 && (e[2] - (2.0 + 2f64.sqrt())).abs() < 1e-12);
}
