//! H1: replaces a force that is not finite by zero.

use super::{GuardFrame, Stage};
use crate::frame::{Cause, DOF};

/// Sets forces to zero where one is not finite, and raises a fault in the same frame.
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
