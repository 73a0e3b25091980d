//! Disjoint sets (union-find).

use alloc::vec::Vec;

/// Disjoint sets of the numbers below `n`.
pub struct Sets(Vec<u32>);

impl Sets {
    /// Creates `n` sets of one number each.
    pub fn new(n: usize) -> Sets {
        Sets((0..n as u32).collect())
    }

    /// Returns the representative of the set of `i`: its smallest number.
    pub fn root(&mut self, i: usize) -> usize {
        let mut i = i as u32;
        while self.0[i as usize] != i {
            let up = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = up;
            i = up;
        }
        i as usize
    }

    /// Joins the sets of `a` and `b`.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}
