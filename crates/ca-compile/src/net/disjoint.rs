//! Disjoint: which things belong together, as sets that are joined and never parted.

use alloc::vec::Vec;

/// Disjoint sets of the numbers below `n`.
pub struct Sets(Vec<u32>);

impl Sets {
    /// Each number by itself.
    pub fn new(n: usize) -> Sets {
        Sets((0..n as u32).collect())
    }

    /// The number that stands for the set of `i`: the least in it.
    pub fn root(&mut self, i: usize) -> usize {
        let mut i = i as u32;
        while self.0[i as usize] != i {
            let up = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = up;
            i = up;
        }
        i as usize
    }

    /// Makes one set of those of `a` and `b`.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}
