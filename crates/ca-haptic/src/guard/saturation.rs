//! H2: no vector of force longer than the device may give, its direction kept.

use super::{Hand, Stage};
use crate::frame::flag;
use crate::profile::Profile;

/// The largest force.
pub struct Saturation {
    axes: usize,
    most: f64,
}

impl Saturation {
    /// As the profile says.
    pub fn new(profile: &Profile) -> Saturation {
        Saturation { axes: profile.axes as usize, most: profile.force }
    }
}

impl Stage for Saturation {
    fn name(&self) -> &'static str {
        "saturation"
    }

    fn pass(&mut self, hand: &mut Hand) {
        for at in (0..hand.n).step_by(self.axes) {
            let size = hand.length(at, self.axes);
            if size > self.most {
                let end = (at + self.axes).min(hand.n);
                for f in &mut hand.force[at..end] {
                    // the quotient first: a force of 1e300 must not overflow on its way
                    *f = (*f / size * self.most).clamp(-self.most, self.most);
                }
                hand.flags |= flag::SATURATED;
            }
        }
    }

    fn reset(&mut self) {}
}
