//! The account of energy at the hand, per degree of freedom, in joules of the real world.
//!
//! Decides to write three sums rather than their differences, each exact (docs/numerics.md §5.3): what the model
//! received by the mean force of each frame, what the hand would have given had the model's force been sent, and what
//! it gave to the force that was sent. The first two are the ledger of the scene
//! ([`Exchange`](ca_core::internal::state::Exchange)) times β/α; the guard's own share is a line of its own, their difference to
//! the third.

use super::GuardFrame;
use crate::frame::DOF;

/// Sums since the engine began \[J\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HandLedger {
    /// energy the model received
    pub received: [f64; DOF],
    /// energy the hand would have given to the forces the model asked for
    pub asked: [f64; DOF],
    /// energy the hand gave to the forces the device held
    pub given: [f64; DOF],
    /// what the model asked for in the frame before \[N\]
    last: [f64; DOF],
}

impl HandLedger {
    /// Records the frame that ends at the present position; `hand.force` is what the model asks for now.
    pub(super) fn frame(&mut self, hand: &GuardFrame) {
        for k in 0..hand.n {
            // a model that diverged receives nothing that could be counted
            if hand.received[k].is_finite() {
                self.received[k] += hand.received[k];
            }
            self.asked[k] -= self.last[k] * hand.moved[k];
            self.given[k] -= hand.acting[k] * hand.moved[k];
            self.last[k] = hand.force[k];
        }
    }

    /// Energy the border made by answering late (+) or taken (−), before the guard \[J\].
    pub fn leak(&self, k: usize) -> f64 {
        self.received[k] - self.asked[k]
    }

    /// Energy that the guard, and a device that takes forces later than the next frame, kept from the hand's work on
    /// the model: what they cut off (+) or added (−) \[J\].
    pub fn removed(&self, k: usize) -> f64 {
        self.asked[k] - self.given[k]
    }
}
