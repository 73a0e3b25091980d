//! Negative springs (bending) and positive ones that cover them: −B across a node is covered by 2B on either side,
//! since (a + b)² ≤ 2(a² + b²).

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

/// Springs between pairs of masses, by sign.
#[derive(Default)]
pub struct Negative {
    positive: BTreeMap<(u32, u32), f64>,
    negative: Vec<(u32, u32, f64)>,
}

impl Negative {
    /// Adds a spring.
    pub fn add(&mut self, i: u32, j: u32, k: f64) {
        if k < 0.0 {
            self.negative.push((i, j, -k));
        } else {
            *self.positive.entry((i.min(j), i.max(j))).or_default() += k;
        }
    }

    /// Returns whether every negative spring is covered.
    pub fn covered(&self) -> bool {
        let mut positive = self.positive.clone();
        let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (i, j) in positive.keys() {
            around.entry(*i).or_default().push(*j);
            around.entry(*j).or_default().push(*i);
        }
        for (i, j, b) in &self.negative {
            let key = |a: u32, c: u32| (a.min(c), a.max(c));
            let need = 2.0 * b * (1.0 - 1e-12);
            let middle = around
                .get(i)
                .into_iter()
                .flatten()
                .copied()
                .find(|m| [key(*i, *m), key(*m, *j)].iter().all(|k| positive.get(k).is_some_and(|v| *v >= need)));
            let Some(m) = middle else { return false };
            for k in [key(*i, m), key(m, *j)] {
                if let Some(v) = positive.get_mut(&k) {
                    *v -= 2.0 * b;
                }
            }
        }
        true
    }
}
