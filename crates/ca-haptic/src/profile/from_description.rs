//! Profile of a device without a profile file, from its own description.
//!
//! A device may report its properties, but not its largest force. Degrees of freedom, axes, travel and rate come from
//! its [`About`], because its own process knows them best. Force, stiffness and speed come from `unknown`, or are less
//! where the device reports less. Its travel only places the soft edges. It gives no force before its description,
//! because the components of a force vector are not yet known.

use super::{Profile, ProfileFault};
use crate::frame::{About, DOF, text};

/// Name of the profile of a device without a profile file.
pub const UNKNOWN: &str = "unknown";
/// Accepted frame rates \[Hz\]; the time for which a force is held grows with the period.
const RATES: [f64; 2] = [100.0, 100_000.0];

impl Profile {
    /// Returns true for a device without a profile file, whose properties come from its [`About`].
    pub fn is_unknown(&self) -> bool {
        self.name == UNKNOWN
    }

    /// Returns this profile without force, for a device with `dof` wanted DOF that has not described itself yet.
    #[must_use]
    pub fn undescribed(&self, dof: u32) -> Profile {
        Profile { dof: dof.clamp(1, DOF as u32), axes: 1, force: 0.0, continuous: None, ..self.clone() }
    }

    /// Returns this profile with the degrees of freedom, axes, travel and rate of the description.
    ///
    /// Force and stiffness stay as in this profile, or less if the device reports less.
    ///
    /// # Errors
    /// The first impossible statement of the device.
    pub fn described(&self, about: &About) -> Result<Profile, ProfileFault> {
        let (n, axes) = (u32::from(about.n), u32::from(about.axes));
        if n == 0 || n as usize > DOF {
            return Err(ProfileFault::SaysDof(n));
        }
        if !(1..=3).contains(&axes) || !n.is_multiple_of(axes) {
            return Err(ProfileFault::SaysAxes(axes, n));
        }
        let all = ..n as usize;
        let low = about.low[all].iter().fold(f64::INFINITY, |m, x| m.min(f64::from(*x)));
        let high = about.high[all].iter().fold(f64::NEG_INFINITY, |m, x| m.max(f64::from(*x)));
        // 0 and non-finite values mean not known
        let least = |own: &[f32]| {
            own[all].iter().filter(|v| v.is_finite() && **v > 0.0).map(|v| f64::from(*v)).min_by(f64::total_cmp)
        };
        let mut p = Profile { dof: n, axes, ..self.clone() };
        if low.is_finite() && high.is_finite() && low < high {
            p.range = [low, high];
        }
        if about.rate > 0 {
            p.rate = f64::from(about.rate).clamp(RATES[0], RATES[1]);
        }
        p.force = least(&about.force).map_or(self.force, |f| f.min(self.force));
        p.continuous = match (self.continuous, least(&about.continuous)) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b.filter(|b| *b < p.force)),
        };
        if let Some(k) = least(&about.stiffness) {
            p.stiffness = Some(self.stiffness.map_or(k, |own| own.min(k)));
        }
        // a slow device gets two more frames before its force is zero
        p.guard.zero = p.guard.zero.max(2.0 * p.hold());
        let title = text(&about.model);
        if !title.is_empty() {
            p.title = title;
        }
        p.sense().map(|()| p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknown() -> Profile {
        Profile::shipped(UNKNOWN).expect("shipped")
    }

    #[test]
    fn what_it_is_comes_from_the_device_and_how_much_it_gives_does_not() {
        for (n, axes) in [(1, 1), (12, 1), (2, 2), (6, 3), (32, 1)] {
            let mut a = About { axes, ..About::new("finger", 500, n) };
            (a.low, a.high, a.force, a.stiffness) = ([-0.02; DOF], [0.03; DOF], [10.0; DOF], [1e5; DOF]);
            let p = unknown().described(&a).expect("it makes sense");
            assert_eq!((p.dof, p.axes, p.rate), (n as u32, u32::from(axes), 500.0));
            assert!((p.range[0] + 0.02).abs() < 1e-9 && (p.range[1] - 0.03).abs() < 1e-9);
            assert_eq!((p.force, p.stiffness), (2.0, Some(500.0)), "never more than nobody has described");
            (a.force[0], a.stiffness[0]) = (0.5, 50.0);
            let p = unknown().described(&a).expect("it makes sense");
            assert_eq!((p.force, p.stiffness), (0.5, Some(50.0)), "less where it says less");
        }
    }

    #[test]
    fn what_says_nothing_or_nonsense_changes_no_limit() {
        let bare = unknown().described(&About::new("finger", 0, 1)).expect("it makes sense");
        assert_eq!((bare.force, bare.range, bare.rate), (2.0, unknown().range, unknown().rate));
        let mut a = About::new("finger", u32::MAX, 1);
        (a.low[0], a.high[0], a.force[0], a.stiffness[0]) = (f32::NAN, f32::INFINITY, f32::NAN, -1.0);
        let p = unknown().described(&a).expect("what it says of these is not used");
        assert_eq!((p.force, p.stiffness, p.range), (2.0, Some(500.0), unknown().range));
        for rate in [1, 60, 400, 570, 1000, 48_000] {
            let p = unknown().described(&About::new("finger", rate, 1)).expect("any rate");
            assert!(p.guard.zero >= 2.0 * p.hold() && p.hold() <= 0.02, "{rate} Hz: {} s", p.hold());
        }
        for (n, axes) in [(0, 1), (33, 1), (4, 3), (1, 0), (8, 4)] {
            let a = About { n, axes, ..About::new("finger", 1000, 1) };
            assert!(unknown().described(&a).is_err(), "{n} in vectors of {axes}");
        }
    }

    #[test]
    fn before_it_has_said_what_it_is_there_is_no_force() {
        let p = unknown().undescribed(5);
        assert_eq!((p.dof, p.axes, p.force), (5, 1, 0.0));
        assert!(p.sense().is_ok() && p.is_unknown());
    }
}
