//! The account of energy at the hand, per degree of freedom, in joules of the real world.
//!
//! It stores three sums rather than their differences, each exact (docs/numerics.md §5.3): energy that the model
//! received through the mean force of each frame, energy that the hand would have given to the model's force, and
//! energy that it gave to the force actually held. The first two are the ledger of the scene
//! ([`Exchange`](ca_core::internal::state::Exchange)) times β/α. The guard's share is the second less the third.

use super::GuardFrame;
use crate::frame::DOF;

/// Sums since the engine began \[J\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HandLedger {
    /// Energy that the model received.
    pub received: [f64; DOF],
    /// Energy that the hand would have given to the forces of the model.
    pub model_work: [f64; DOF],
    /// Energy that the hand gave to the forces that the device held.
    pub hand_work: [f64; DOF],
    /// Force of the model in the frame before \[N\].
    last: [f64; DOF],
}

impl HandLedger {
    /// Records the frame that ends at the present position; `hand.force` is still the force of the model.
    pub(super) fn frame(&mut self, hand: &GuardFrame) {
        for k in 0..hand.n {
            // energy of a diverged model is not finite and is left out
            if hand.received[k].is_finite() {
                self.received[k] += hand.received[k];
            }
            self.model_work[k] -= self.last[k] * hand.moved[k];
            self.hand_work[k] -= hand.acting[k] * hand.moved[k];
            self.last[k] = hand.force[k];
        }
    }

    /// Returns the energy that the rate boundary made (+) or took (−) by its delay, before the guard \[J\].
    pub fn leak(&self, k: usize) -> f64 {
        self.received[k] - self.model_work[k]
    }

    /// Returns the energy withheld from (+) or added to (−) the hand's work on the model \[J\], by the guard and by a
    /// device that uses forces later than the next frame.
    pub fn removed(&self, k: usize) -> f64 {
        self.model_work[k] - self.hand_work[k]
    }
}
