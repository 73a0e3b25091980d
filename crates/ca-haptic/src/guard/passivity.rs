//! H12: the border gives no energy that the hand did not bring.
//!
//! Decides on the exact account of numerics 5.3 instead of an estimate from sampled force and speed: the model received
//! F̄·Δ in this frame, the hand gave u·Δ with the force u it was really sent in the frame before. Their sum over
//! frames, the leak, is energy made by answering late; while it is positive and the hand moves, a force against the
//! motion takes it back within the frame. Taking it at the rate of the leak is all there is to tune: nothing is.
//!
//! The account begins anew whenever forces are not fully on: fading in, the hand gives less than the model receives by
//! intent. A device slower than the engine moves in some frames only, and keeps what was injected until it moves again.
//! The account is in joules of the hand, so equivalence factors are in it already.

use super::saturation::limit;
use super::{Hand, Stage, norm};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Motion in a frame \[m\] below which nothing is injected: a nanometre, finer than any sensor of a hand.
const STILL: f64 = 1e-9;

/// Observer and controller, per vector of force.
pub struct Passivity {
    axes: usize,
    most: f64,
    leak: [f64; DOF],
    inject: [f64; DOF],
    viscosity: [f64; DOF],
}

impl Passivity {
    /// As the profile says; `None` where it is not wanted.
    pub fn new(profile: &Profile) -> Option<Passivity> {
        (profile.guard.passivity && profile.force > 0.0).then_some(Passivity {
            axes: profile.axes as usize,
            most: profile.force,
            leak: [0.0; DOF],
            inject: [0.0; DOF],
            viscosity: [0.0; DOF],
        })
    }
}

impl Stage for Passivity {
    fn name(&self) -> &'static str {
        "passivity"
    }

    fn pass(&mut self, hand: &mut Hand) {
        for at in (0..hand.n).step_by(self.axes) {
            let end = (at + self.axes).min(hand.n);
            // the mode is still that of the frame before: the force that did the work
            if hand.mode != Mode::On {
                self.leak[at] = 0.0;
                self.inject[at..end].fill(0.0);
                continue;
            }
            let made: f64 = (at..end).map(|k| hand.received[k] + hand.sent[k] * hand.moved[k]).sum();
            if made.is_finite() {
                self.leak[at] += made;
            }
            let path = norm(&hand.moved[at..end]);
            if hand.fresh || path > 0.0 {
                self.inject[at..end].fill(0.0);
                self.viscosity[at] = 0.0;
                if self.leak[at] > 0.0 && path > STILL {
                    let size = (self.leak[at] / path).min(self.most);
                    for k in at..end {
                        self.inject[k] = -size * hand.moved[k] / path;
                    }
                    self.viscosity[at] = size * hand.te / path;
                }
            }
            if self.inject[at..end].iter().any(|f| *f != 0.0) {
                for k in at..end {
                    hand.force[k] += self.inject[k];
                }
                limit(&mut hand.force[at..end], self.most);
                hand.inject = hand.inject.max(self.viscosity[at]);
                hand.flags |= flag::PASSIVITY;
            }
        }
    }
}
