//! H12: the border gives no energy that the hand did not bring.
//!
//! Decides on the exact account of numerics 5.3 instead of an estimate from sampled force and speed: the model received
//! F̄·Δ in this frame, the hand gave u·Δ with the force u the device really held: the one it says it used, else what
//! was sent in the frame before. Their difference over frames, the leak, is energy made by answering late; while it is
//! positive and the hand moves, a force against the motion takes it back within the frame, as far as that does not turn
//! the motion round: the viscosity of the injection is at most m/T, with the mass of the bare device and its own frame,
//! which stops it dead. Without that bound what is owed is paid at the turning points, where a nanometre of motion would
//! ask for the largest force there is, and a wall of 20 kN/m at rest is kicked by 0.1 mm every few seconds.
//!
//! The account begins anew whenever forces are not fully on: fading in, the hand gives less than the model receives by
//! intent. A device slower than the engine moves in some frames only, and keeps what was injected until it moves again.
//! The account is in joules of the hand, so equivalence factors are in it already.

use super::saturation::limit;
use super::{Hand, Stage, norm};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Observer and controller, per vector of force.
pub struct Passivity {
    axes: usize,
    most: f64,
    /// largest force per motion in a frame \[N/m\]
    stop: f64,
    leak: [f64; DOF],
    inject: [f64; DOF],
    viscosity: [f64; DOF],
}

impl Passivity {
    /// As the profile says; `None` where it is not wanted.
    pub fn new(profile: &Profile, te: f64) -> Option<Passivity> {
        let frame = te.max(1.0 / profile.rate);
        (profile.guard.passivity && profile.force > 0.0).then_some(Passivity {
            axes: profile.axes as usize,
            most: profile.force,
            stop: profile.body.mass / (frame * frame),
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
            let made: f64 = (at..end).map(|k| hand.received[k] + hand.acting[k] * hand.moved[k]).sum();
            if made.is_finite() {
                self.leak[at] += made;
            }
            let path = norm(&hand.moved[at..end]);
            if hand.fresh || path > 0.0 {
                self.inject[at..end].fill(0.0);
                self.viscosity[at] = 0.0;
                if self.leak[at] > 0.0 && path > 0.0 {
                    // of a slower device the motion of its whole frame is seen at once
                    let size = (self.leak[at] / path).min(self.most).min(self.stop * path);
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
