//! Waveguides as records of the network. The pass `waves` tunes them.

use ca_core::internal::tuning::wave::{Tuned, WaveguideSpec};

/// A waveguide.
#[derive(Clone, Debug)]
pub struct WaveguideNode {
    /// Item it was made from.
    pub item: u32,
    /// First junction, by document number; the others follow.
    pub first: u32,
    /// Specification.
    pub spec: WaveguideSpec,
    /// Specification in samples; `None` before tuning, or if tuning fails.
    pub tuned: Option<Tuned>,
}

impl WaveguideNode {
    /// Returns its junctions, by document number.
    pub fn junctions(&self) -> core::ops::Range<u32> {
        self.first..self.first + self.spec.at.len() as u32
    }

    /// Returns its static stiffness \[N/m\]: springs from each junction to the one before, or to ground. The lossy end
    /// yields over time and is not counted.
    pub fn springs(&self, tick_dt: f64) -> impl Iterator<Item = (u32, Option<u32>, f64)> {
        let between = move |i: usize, delay: usize| {
            let k = self.spec.z / (tick_dt * delay as f64);
            let m = self.first + i as u32;
            if i == 0 { (m, None, 2.0 * k) } else { (m, Some(m - 1), k) }
        };
        let delays = self.tuned.iter().flat_map(|t| &t.delays);
        delays.take(self.spec.at.len()).enumerate().map(move |(i, d)| between(i, *d))
    }
}
