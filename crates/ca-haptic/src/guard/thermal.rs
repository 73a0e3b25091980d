//! H4: no more force on the average than the motors stand for ever.
//!
//! Decides on a budget rather than a fuse: heat is the mean square of what was really sent, of first order over
//! `thermal` seconds, and in its last fifth the largest force comes down from the peak to the continuous rating, which
//! is then kept exactly for as long as it takes. So it never becomes a fault by itself; the cause THERMAL is what a
//! device that measures its motors reports. Arming does not cool a motor: the heat stays.

use super::saturation::limit;
use super::{GuardFrame, Stage, norm};
use crate::frame::{DOF, flag};
use crate::profile::Profile;

/// A budget per vector of force.
pub struct Thermal {
    axes: usize,
    peak: f64,
    rating: f64,
    share: f64,
    /// mean square of the force \[N²\]
    heat: [f64; DOF],
}

/// The part of the budget over which the peak comes down.
const LAST: f64 = 0.2;

impl Thermal {
    /// As the profile says, at frames of `frame_dt` seconds; `None` for a device that stands its largest force for ever.
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
            // what fills the budget in this very frame
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
