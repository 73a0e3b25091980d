//! Lays out waveguides and their memory.

use crate::emit::layout_builder::LayoutBuilder;
use alloc::vec::Vec;
use ca_core::internal::op::layout::{Delay, Junction, Termination, Waves};
use ca_core::internal::tuning::wave::Loss;

impl LayoutBuilder<'_> {
    /// Lays out the waveguides; their memory begins at `memory`.
    pub fn waves(&self, memory: usize) -> Waves {
        let mut all = Waves { first: memory, ..Waves::default() };
        let mut next = memory;
        let mut take = |n: usize| {
            next += n;
            next - n
        };
        for line in &self.net.lines {
            let Some(tuned) = &line.tuned else { continue };
            let base = all.junctions.len();
            let z = line.spec.z / self.net.tick_dt;
            for m in line.junctions() {
                all.junctions.push(Junction { mat: self.slot[m as usize], z, memory: take(3) });
            }
            let last = tuned.delays.len() - 1;
            for (i, len) in tuned.delays.iter().copied().enumerate() {
                // Before the first junction and after the last, a wave returns to where it came from.
                let sides = [(i > 0).then(|| (base + i - 1, 1)), (i < last).then_some((base + i, 0))];
                let [left, right] = sides;
                let mut lossy = |loss: Loss| Termination::Lossy { loss, memory: take(1) };
                // Taps and allpass of the near end take two samples of its delay; a ring with taps needs three more.
                let ways = match (left, right, tuned.near) {
                    (Some(a), Some(b), _) => {
                        alloc::vec![(a, b, Termination::Open, len), (b, a, Termination::Open, len)]
                    }
                    (Some(a), None, _) => alloc::vec![(a, a, lossy(tuned.loss), len + 3)],
                    (None, Some(b), Some(near)) => alloc::vec![(b, b, lossy(near), len + 1)],
                    (None, Some(b), None) => alloc::vec![(b, b, Termination::Rigid, len)],
                    (None, None, _) => Vec::new(),
                };
                for ((junction, side), (other, there), end, len) in ways {
                    let from = all.junctions[junction].memory + side;
                    let to = all.junctions[other].memory + there;
                    all.delays.push(Delay { junction, from, to, first: take(len), len, end });
                }
            }
        }
        all.len = next - memory;
        all
    }
}
