//! What makes no sense in a profile: numbers that are none, and limits so large that a hand would be without them.
//!
//! Decides on fixed bounds, far beyond every device there is, rather than on trust: a slip of a digit, or `1e300` for
//! "none", would switch off what protects a hand without a word.

use super::Profile;

/// Shortest time in which a force may begin or fade in \[s\].
const SOON: f64 = 0.01;

impl Profile {
    /// The first thing about it that makes no sense.
    pub(super) fn sense(&self) -> Result<(), String> {
        let l = &self.guard;
        let positive = [
            ("guard.speed", l.speed),
            ("guard.thermal", l.thermal),
            ("guard.clear", l.clear),
            ("guard.clear_time", l.clear_time),
            ("guard.ramp", l.ramp),
            ("guard.approach", l.approach),
            ("guard.hold", self.hold()),
            ("guard.zero", l.zero),
            ("guard.ttl", l.ttl),
            ("guard.bad_time", l.bad_time),
            ("guard.oscillation_time", l.oscillation_time),
            ("guard.passivity_band", l.passivity_band),
            ("guard.passivity_leak", l.passivity_leak),
            ("rate", self.rate),
            ("body.mass", self.body.mass),
        ];
        for (name, v) in positive {
            if !(v.is_finite() && v > 0.0) {
                return Err(format!("`{name}` must be more than 0, it is {v}"));
            }
        }
        let rest = [
            ("force", Some(self.force)),
            ("continuous", self.continuous),
            ("stiffness", self.stiffness),
            ("damping", self.damping),
            ("guard.slew", l.slew),
            ("guard.brake", Some(l.brake)),
            ("guard.stop", Some(l.stop)),
            ("guard.edge", Some(l.edge)),
            ("guard.edge_stiffness", l.edge_stiffness),
            ("guard.passivity_viscosity", Some(l.passivity_viscosity)),
            ("guard.passivity_force", Some(l.passivity_force)),
            ("guard.oscillation_level", Some(l.oscillation_level)),
            ("guard.oscillation_gain", Some(l.oscillation_gain)),
            ("body.friction", Some(self.body.friction)),
            ("body.dry", Some(self.body.dry)),
            ("body.step", Some(self.body.step)),
            ("body.noise", Some(self.body.noise)),
            ("body.force_step", Some(self.body.force_step)),
        ];
        for (name, v) in rest {
            if v.is_some_and(|v| !(v.is_finite() && v >= 0.0)) {
                return Err(format!("`{name}` must not be negative, it is {}", v.unwrap_or_default()));
            }
        }
        let most = [
            ("force", self.force, 1000.0, "N"),
            ("continuous", self.continuous(), self.force, "N, the largest force"),
            ("stiffness", self.stiffness.unwrap_or(0.0), 1e7, "N/m"),
            ("damping", self.damping.unwrap_or(0.0), 1e5, "N s/m"),
            ("rate", self.rate, 100_000.0, "Hz"),
            ("body.mass", self.body.mass, 1000.0, "kg"),
            ("body.friction", self.body.friction, 1000.0, "N s/m"),
            ("body.dry", self.body.dry, 1000.0, "N"),
            ("body.step", self.body.step, 0.01, "m"),
            ("body.noise", self.body.noise, 0.01, "m"),
            ("body.force_step", self.body.force_step, 1000.0, "N"),
            ("guard.speed", l.speed, 20.0, "m/s"),
            ("guard.slew", l.slew.unwrap_or(0.0), 1e8, "N/s"),
            ("guard.thermal", l.thermal, 3600.0, "s"),
            ("guard.clear", l.clear, 1.0, "of the largest force"),
            ("guard.clear_time", l.clear_time, 60.0, "s"),
            ("guard.ramp", l.ramp, 60.0, "s"),
            ("guard.approach", l.approach, 60.0, "s"),
            ("guard.hold", self.hold(), 0.5, "s"),
            ("guard.zero", l.zero, 1.0, "s"),
            ("guard.ttl", l.ttl, 0.5, "s"),
            ("guard.brake", l.brake, 1000.0, "N s/m"),
            ("guard.stop", l.stop, 10.0, "s"),
            ("guard.bad_time", l.bad_time, 10.0, "s"),
            ("guard.edge_stiffness", l.edge_stiffness.unwrap_or(0.0), 1e6, "N/m"),
            ("guard.oscillation_level", l.oscillation_level, 1.0, "of the largest force"),
            ("guard.oscillation_time", l.oscillation_time, 10.0, "s"),
            ("guard.passivity_leak", l.passivity_leak, 0.01, "J"),
        ];
        for (name, v, most, unit) in most {
            if v > most {
                return Err(format!(
                    "`{name}` is at most {most} {unit}, it is {v}: more would leave a hand without this limit"
                ));
            }
        }
        for (name, v) in [("ramp", l.ramp), ("approach", l.approach), ("clear_time", l.clear_time)] {
            if v < SOON {
                return Err(format!("`guard.{name}` is at least {SOON} s, it is {v}: less is a jump"));
            }
        }
        if self.dof == 0 || self.dof as usize > crate::frame::DOF {
            return Err(format!("`dof` lies between 1 and {}, it is {}", crate::frame::DOF, self.dof));
        }
        if self.axes == 0 || self.axes > 3 || !self.dof.is_multiple_of(self.axes) {
            return Err(format!("`axes` is 1, 2 or 3 and divides `dof` = {}, it is {}", self.dof, self.axes));
        }
        if !(self.range[0].is_finite() && self.range[1].is_finite() && self.range[0] < self.range[1]) {
            return Err("`range` = [least, largest] in metres".into());
        }
        if l.zero <= self.hold() {
            return Err("`guard.zero` must be later than `guard.hold`".into());
        }
        let [low, high] = l.oscillation_band;
        if !(low > 0.0 && low.is_finite() && high > low) {
            return Err(
                "`guard.oscillation_band` = [lowest, highest] in hertz, more than 0; `inf` for all above".into()
            );
        }
        for (name, v) in [("passivity_viscosity", l.passivity_viscosity), ("passivity_force", l.passivity_force)] {
            if v > 1.0 {
                return Err(format!("`guard.{name}` is a part of what the device has: at most 1, it is {v}"));
            }
        }
        if l.oscillation_gain > 1.0 {
            return Err(format!("`guard.oscillation_gain` weakens: at most 1, it is {}", l.oscillation_gain));
        }
        if l.bad == 0 || l.bad > 64 {
            return Err(format!("`guard.bad` lies between 1 and 64, it is {}", l.bad));
        }
        if l.edge >= 0.5 {
            return Err("`guard.edge` is less than half of the travel".into());
        }
        Ok(())
    }
}
