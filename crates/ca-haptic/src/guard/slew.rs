//! H3: limits the change of a force to what the stiffest thing the device renders could cause.
//!
//! Off and fault are zero at once.

use super::{GuardFrame, Stage, norm};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Limit of the change per frame.
pub struct Slew {
    axes: usize,
    most: f64,
}

impl Slew {
    /// Builds the limit from a profile, at `frame_dt` seconds a frame.
    pub fn new(profile: &Profile, frame_dt: f64) -> Slew {
        Slew { axes: profile.axes as usize, most: profile.slew() * frame_dt }
    }
}

impl Stage for Slew {
    fn name(&self) -> &'static str {
        "slew"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        if matches!(hand.mode, Mode::Off | Mode::Fault) {
            return;
        }
        let mut step = [0.0; DOF];
        for at in (0..hand.n).step_by(self.axes) {
            let end = (at + self.axes).min(hand.n);
            for (k, step) in step.iter_mut().enumerate().take(end).skip(at) {
                *step = hand.force[k] - hand.sent[k];
            }
            let size = norm(&step[at..end]);
            if size > self.most {
                for (k, step) in step.iter().enumerate().take(end).skip(at) {
                    hand.force[k] = hand.sent[k] + step / size * self.most;
                }
                hand.flags |= flag::SLEWED;
            }
        }
    }
}
