//! H4: keeps the r.m.s. force within the continuous rating of the motors.
//!
//! It is a budget rather than a fuse. Heat is the mean square of the force sent, with the time constant `thermal`. In
//! the last fifth of the budget the largest force falls from the peak to the continuous rating, where it stays as long
//! as needed, so this stage never raises a fault. The cause THERMAL comes from a device that measures its motors.
//! Arming does not cool a motor: the heat stays.

use super::saturation::limit;
use super::{GuardFrame, Stage, norm};
use crate::frame::{DOF, flag};
use crate::profile::Profile;

/// Budget per force vector.
pub struct Thermal {
    axes: usize,
    peak: f64,
    rating: f64,
    share: f64,
    /// Mean square of the force \[N²\].
    heat: [f64; DOF],
}

/// Part of the budget over which the peak force falls.
const LAST: f64 = 0.2;

impl Thermal {
    /// Builds the budget from a profile, at `frame_dt` seconds a frame; `None` if `continuous` is at least `force`.
    pub fn new(profile: &Profile, frame_dt: f64) -> Option<Thermal> {
        let (peak, rating) = (profile.force, profile.continuous());
        (rating < peak).then(|| Thermal {
            axes: profile.axes as usize,
            peak,
            rating,
            share: frame_dt / (frame_dt + profile.guard.thermal),
            heat: [0.0; DOF],
        })
    }
}

impl Stage for Thermal {
    fn name(&self) -> &'static str {
        "thermal"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        let full = self.rating * self.rating;
        for at in (0..hand.n).step_by(self.axes) {
            let left = (full - self.heat[at]).max(0.0);
            let soft = self.rating + (self.peak - self.rating) * (left / (LAST * full).max(f64::MIN_POSITIVE)).min(1.0);
            // force that would use up the budget in this frame
            let hard = (full + left * (1.0 / self.share - 1.0)).sqrt();
            if limit(&mut hand.force[at..(at + self.axes).min(hand.n)], soft.min(hard)) {
                hand.flags |= flag::THERMAL;
            }
        }
    }

    fn sent(&mut self, hand: &GuardFrame) {
        for at in (0..hand.n).step_by(self.axes) {
            let f = norm(&hand.force[at..(at + self.axes).min(hand.n)]);
            self.heat[at] += self.share * (f * f - self.heat[at]);
        }
    }
}
