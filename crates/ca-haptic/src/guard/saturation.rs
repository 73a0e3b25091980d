//! H2: shortens each force vector to the largest force of the device, and keeps its direction.

use super::{GuardFrame, Stage, norm};
use crate::frame::flag;
use crate::profile::Profile;

/// Limit of the force vectors.
pub struct Saturation {
    axes: usize,
    most: f64,
}

impl Saturation {
    /// Builds the limit from a profile.
    pub fn new(profile: &Profile) -> Saturation {
        Saturation { axes: profile.axes as usize, most: profile.force }
    }
}

/// Shortens `v` to the length `most`; returns true if it was longer.
pub(super) fn limit(v: &mut [f64], most: f64) -> bool {
    let large = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if large > most {
        // scaled first so that the square is finite: a force of 1e300 keeps its direction too
        for x in &mut *v {
            *x /= large;
        }
    } else if norm(v) <= most {
        return false;
    }
    let size = norm(v);
    for x in v {
        *x = (*x / size * most).clamp(-most, most);
    }
    true
}

impl Stage for Saturation {
    fn name(&self) -> &'static str {
        "saturation"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        for at in (0..hand.n).step_by(self.axes) {
            let end = (at + self.axes).min(hand.n);
            limit(&mut hand.mean[at..end], self.most);
            if limit(&mut hand.force[at..end], self.most) {
                hand.flags |= flag::SATURATED;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_directions_of_any_size() {
        for scale in [1e-300, 1e-3, 1.0, 2.0, 1e10, 1e160, 5e307] {
            let mut v = [2.0 * scale, -scale, 2.0 * scale];
            let cut = limit(&mut v, 6.0);
            assert_eq!(cut, scale > 2.0, "{scale}");
            let size = norm(&v.map(|x| x / v[0].abs())) * v[0].abs();
            assert!(size <= 6.0 * (1.0 + 1e-15), "{scale}: {v:?}");
            assert!((v[0] / v[1] + 2.0).abs() < 1e-12 && v[0] == v[2], "{scale}: {v:?}");
        }
        let mut none = [1.0, 2.0];
        assert!(limit(&mut none, 0.0) && none == [0.0, 0.0]);
    }
}
