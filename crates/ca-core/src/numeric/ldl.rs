//! LDLᵀ factorisation of a sparse symmetric matrix, for systems that are solved in every tick (docs/numerics.md §3.1).
//!
//! This is custom code, while everything computed once uses faer. A library that chooses vector instructions by machine
//! gives different last bits on different machines, and a scene must give the same bits everywhere.
//!
//! Positive definite matrices need no pivots, so the elimination order is chosen once, from the pattern: always the
//! column with the fewest remaining neighbours. For strings this causes no fill-in, for meshes little.

use crate::numeric::Real;
use alloc::collections::BTreeSet;
use alloc::vec::Vec;

/// Pattern of L below its diagonal, by columns, in elimination order.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Pattern {
    /// original index of each row, in elimination order (n)
    pub order: Vec<u32>,
    /// first entry of each column (n + 1)
    pub columns: Vec<u32>,
    /// row of each entry, rising within a column
    pub rows: Vec<u32>,
}

/// Merges two rising lists into `to`, without the two values `but`.
fn union(a: &[u32], b: &[u32], but: [u32; 2], to: &mut Vec<u32>) {
    to.clear();
    let (mut a, mut b) = (a, b);
    while let (Some(x), Some(y)) = (a.first(), b.first()) {
        let least = *x.min(y);
        (a, b) = (&a[usize::from(*x == least)..], &b[usize::from(*y == least)..]);
        to.push(least);
    }
    to.extend(a);
    to.extend(b);
    to.retain(|v| !but.contains(v));
}

impl Pattern {
    /// Makes the pattern for `n` rows with these couplings, or `None` if L would have more than `most` entries.
    pub fn new(n: usize, pairs: impl Iterator<Item = (u32, u32)>, most: usize) -> Option<Pattern> {
        let mut near: Vec<Vec<u32>> = alloc::vec![Vec::new(); n];
        for (i, j) in pairs.filter(|(i, j)| i != j) {
            near[i as usize].push(j);
            near[j as usize].push(i);
        }
        for s in &mut near {
            s.sort_unstable();
            s.dedup();
        }
        let mut left: BTreeSet<(usize, u32)> = near.iter().zip(0..).map(|(s, i)| (s.len(), i)).collect();
        let (mut order, mut below, mut all) = (Vec::with_capacity(n), Vec::with_capacity(n), 0);
        let mut joined = Vec::new();
        while let Some((fewest, i)) = left.pop_first() {
            let around = core::mem::take(&mut near[i as usize]);
            all += around.len();
            // once every remaining row is coupled to all others (common at the end), the rest of the pattern is known
            let others = left.len();
            let full = fewest == others;
            if all > most || (full && all + others * others.saturating_sub(1) / 2 > most) {
                return None;
            }
            order.push(i);
            if full {
                order.extend(&around);
                below.extend((0..=others).map(|k| around[k..].to_vec()));
                all += others * others.saturating_sub(1) / 2;
                break;
            }
            for j in &around {
                let s = &mut near[*j as usize];
                left.remove(&(s.len(), *j));
                union(s, &around, [i, *j], &mut joined);
                core::mem::swap(s, &mut joined);
                left.insert((s.len(), *j));
            }
            below.push(around);
        }
        let mut at = alloc::vec![0_u32; n];
        order.iter().zip(0..).for_each(|(i, k)| at[*i as usize] = k);
        let mut p = Pattern { order, columns: alloc::vec![0], rows: Vec::with_capacity(all) };
        for column in below {
            let first = p.rows.len();
            p.rows.extend(column.iter().map(|i| at[*i as usize]));
            p.rows[first..].sort_unstable();
            p.columns.push(p.rows.len() as u32);
        }
        Some(p)
    }

    /// Returns the number of rows.
    pub fn size(&self) -> usize {
        self.order.len()
    }

    /// Returns how many numbers a factor has.
    pub fn numbers(&self) -> usize {
        self.size() + self.rows.len()
    }

    fn column(&self, j: usize) -> core::ops::Range<usize> {
        self.columns[j] as usize..self.columns[j + 1] as usize
    }

    fn place(&self, i: u32, j: usize) -> Option<usize> {
        let r = self.column(j);
        self.rows[r.clone()].binary_search(&i).ok().map(|k| r.start + k)
    }

    /// Turns row sums into the factor, in place. Returns false if the matrix is not positive definite or not finite.
    ///
    /// `v` holds the row sums (n) and is left with 1/D (n), then L. `beside` gives each off-diagonal entry once, as
    /// row, column and value in elimination order; entries at the same position add up. `around` is working memory.
    /// Nothing is allocated once both have their capacity.
    ///
    /// With row sums in place of the diagonal nothing is ever subtracted if all couplings are springs. A mass on a
    /// spring of 10¹² times its inertia thus keeps all its digits.
    pub fn factor(
        &self,
        v: &mut Vec<f64>,
        around: &mut Vec<f64>,
        beside: impl Iterator<Item = (u32, u32, f64)>,
    ) -> bool {
        let n = self.size();
        v.resize(n + self.rows.len(), 0.0);
        // sums of the off-diagonal entries of each row, left and right of the diagonal
        around.clear();
        around.resize(n, 0.0);
        for (i, j, a) in beside {
            let Some(at) = self.place(i.max(j), i.min(j) as usize) else { return false };
            v[n + at] += a;
            around[i as usize] += a;
            around[j as usize] += a;
        }
        for k in 0..n {
            let (d, sum) = (v[k] - around[k], v[k]);
            if !(d > 0.0 && d.is_finite()) {
                return false;
            }
            let r = self.column(k);
            for p in r.clone() {
                let (a, j) = (v[n + p], self.rows[p] as usize);
                let l = a / d;
                v[j] -= l * sum;
                around[j] -= a;
                for q in p + 1..r.end {
                    let (i, more) = (self.rows[q], l * v[n + q]);
                    let Some(at) = self.place(i, j) else { return false };
                    v[n + at] -= more;
                    around[j] -= more;
                    around[i as usize] -= more;
                }
            }
            for p in r {
                v[n + p] /= d;
            }
            v[k] = 1.0 / d;
        }
        v.iter().all(|v| v.is_finite())
    }

    /// Solves in place with the numbers of [`Pattern::factor`]. Rows are in elimination order. Does not allocate.
    #[inline]
    pub fn solve<R: Real>(&self, numbers: &[R], y: &mut [R]) {
        let n = self.size();
        let (d, l) = numbers.split_at(n);
        for j in 0..n {
            let v = y[j];
            for p in self.column(j) {
                y[self.rows[p] as usize] -= l[p] * v;
            }
        }
        for j in (0..n).rev() {
            let mut v = y[j] * d[j];
            for p in self.column(j) {
                v -= l[p] * y[self.rows[p] as usize];
            }
            y[j] = v;
        }
    }
}
