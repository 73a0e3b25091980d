//! H1: a force that is not finite never leaves.

use super::{GuardFrame, Stage};
use crate::frame::{Cause, DOF};

/// Zero instead, and a fault in the same frame.
pub struct Finite;

impl Stage for Finite {
    fn name(&self) -> &'static str {
        "finite"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        if hand.force[..hand.n].iter().any(|f| !f.is_finite()) {
            (hand.force, hand.mean) = ([0.0; DOF], [0.0; DOF]);
            hand.trip(Cause::Nonfinite);
        }
    }
}
