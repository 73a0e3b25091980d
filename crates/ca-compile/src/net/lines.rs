//! Lines: the strings of waves in the network, as records; the pass `waves` tunes them.

use ca_core::internal::tuning::wave::{Tuned, WaveguideSpec};

/// A string of waves.
#[derive(Clone, Debug)]
pub struct LineNode {
    /// the item it was made from
    pub item: u32,
    /// its first junction, by document number; the others follow
    pub first: u32,
    /// what was asked for
    pub asked: WaveguideSpec,
    /// what that is in samples; `None` before it is settled, or where it cannot be
    pub tuned: Option<Tuned>,
}

impl LineNode {
    /// Its junctions, by document number.
    pub fn junctions(&self) -> core::ops::Range<u32> {
        self.first..self.first + self.asked.at.len() as u32
    }

    /// What it is to a steady pull: from each junction a spring to the one before, or to the ground \[N/m\]. The
    /// lossy end gives way in time, and counts for nothing.
    pub fn springs(&self, tick_dt: f64) -> impl Iterator<Item = (u32, Option<u32>, f64)> {
        let between = move |i: usize, delay: usize| {
            let k = self.asked.z / (tick_dt * delay as f64);
            let m = self.first + i as u32;
            if i == 0 { (m, None, 2.0 * k) } else { (m, Some(m - 1), k) }
        };
        let delays = self.tuned.iter().flat_map(|t| &t.delays);
        delays.take(self.asked.at.len()).enumerate().map(move |(i, d)| between(i, *d))
    }
}
