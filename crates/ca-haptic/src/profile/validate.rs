//! Checks a profile for invalid numbers and for limits so large that they would not protect a hand.
//!
//! The bounds are fixed, far beyond any real device: a wrong digit, or `1e300` for "none", must not silently switch off
//! a protection.

use super::{Profile, ProfileFault};

/// Shortest time in which a force may begin or fade in \[s\].
const SOON: f64 = 0.01;
/// Lower bound of numbers that must be positive.
const ABOVE: f64 = f64::MIN_POSITIVE;

impl Profile {
    pub(super) fn sense(&self) -> Result<(), ProfileFault> {
        let l = &self.guard;
        let all = [
            ("force", Some(self.force), 0.0, 1000.0, "N"),
            ("continuous", self.continuous, 0.0, self.force, "N, the largest force"),
            ("stiffness", self.stiffness, 0.0, 1e7, "N/m"),
            ("damping", self.damping, 0.0, 1e5, "N s/m"),
            ("rate", Some(self.rate), ABOVE, 100_000.0, "Hz"),
            ("body.mass", Some(self.body.mass), ABOVE, 1000.0, "kg"),
            ("body.friction", Some(self.body.friction), 0.0, 1000.0, "N s/m"),
            ("body.dry", Some(self.body.dry), 0.0, 1000.0, "N"),
            ("body.step", Some(self.body.step), 0.0, 0.01, "m"),
            ("body.noise", Some(self.body.noise), 0.0, 0.01, "m"),
            ("body.force_step", Some(self.body.force_step), 0.0, 1000.0, "N"),
            ("guard.speed", Some(l.speed), ABOVE, 20.0, "m/s"),
            ("guard.slew", l.slew, 0.0, 1e8, "N/s"),
            ("guard.thermal", Some(l.thermal), ABOVE, 3600.0, "s"),
            ("guard.clear", Some(l.clear), ABOVE, 1.0, "of the largest force"),
            ("guard.clear_time", Some(l.clear_time), SOON, 60.0, "s"),
            ("guard.ramp", Some(l.ramp), SOON, 60.0, "s"),
            ("guard.approach", Some(l.approach), SOON, 60.0, "s"),
            ("guard.hold", Some(self.hold()), ABOVE, 0.5, "s"),
            ("guard.zero", Some(l.zero), ABOVE, 1.0, "s"),
            ("guard.ttl", Some(l.ttl), ABOVE, 0.5, "s"),
            ("guard.brake", Some(l.brake), 0.0, 1000.0, "N s/m"),
            ("guard.stop", Some(l.stop), 0.0, 10.0, "s"),
            ("guard.bad_time", Some(l.bad_time), ABOVE, 10.0, "s"),
            ("guard.edge", Some(l.edge), 0.0, 0.5, "of the travel"),
            ("guard.edge_stiffness", l.edge_stiffness, 0.0, 1e6, "N/m"),
            ("guard.passivity_viscosity", Some(l.passivity_viscosity), 0.0, 1.0, "of the friction of the device"),
            ("guard.passivity_force", Some(l.passivity_force), 0.0, 1.0, "of the largest force"),
            ("guard.passivity_band", Some(l.passivity_band), ABOVE, f64::MAX, "Hz"),
            ("guard.passivity_leak", Some(l.passivity_leak), ABOVE, 0.01, "J"),
            ("guard.oscillation_level", Some(l.oscillation_level), 0.0, 1.0, "of the largest force"),
            ("guard.oscillation_time", Some(l.oscillation_time), ABOVE, 10.0, "s"),
            ("guard.oscillation_gain", Some(l.oscillation_gain), 0.0, 1.0, "of the force"),
        ];
        for (name, v, least, most, unit) in all {
            let Some(v) = v else { continue };
            if v.is_nan() || v < least {
                return Err(match least {
                    0.0 => ProfileFault::Negative(name, v),
                    SOON => ProfileFault::Short(name, SOON, v),
                    _ => ProfileFault::NotAbove(name, v),
                });
            }
            if v > most {
                return Err(ProfileFault::Large(name, most, v, unit));
            }
        }
        if self.dof == 0 || self.dof as usize > crate::frame::DOF {
            return Err(ProfileFault::Dof(self.dof));
        }
        if self.axes == 0 || self.axes > 3 || !self.dof.is_multiple_of(self.axes) {
            return Err(ProfileFault::Axes(self.axes, self.dof));
        }
        if !(self.range[0].is_finite() && self.range[1].is_finite() && self.range[0] < self.range[1]) {
            return Err(ProfileFault::Range);
        }
        if l.zero <= self.hold() {
            return Err(ProfileFault::Zero);
        }
        let [low, high] = l.oscillation_band;
        if !(low > 0.0 && low.is_finite() && high > low) {
            return Err(ProfileFault::Band);
        }
        if l.bad == 0 || l.bad > 64 {
            return Err(ProfileFault::Bad(l.bad));
        }
        if l.edge >= 0.5 {
            return Err(ProfileFault::Edge);
        }
        Ok(())
    }
}
