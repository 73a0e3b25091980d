//! Device profiles: every number that protects a hand, in one text file per device.
//!
//! Decides that no number of the guard stands in code: `profiles/<name>.toml` holds what is known of the device with
//! its source, and what the guard uses of it by default ([`Limits`]); a file of the user's own overrides any of them.
//! A device nobody has described is `unknown`: 2 N, slow, soft, of as many degrees of freedom as it says it has.

mod described;

pub use described::UNKNOWN;

use crate::error::{FileError, FileErrorKind};
use serde::{Deserialize, Serialize};

/// A device, as the guard and the simulation see it. Per degree of freedom where not said otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// name, as in `--profile`
    pub name: String,
    /// make and model
    pub title: String,
    /// where the numbers are from
    pub source: String,
    /// degrees of freedom, at most 32
    pub dof: u32,
    /// how many neighbouring DOF make one force vector: 1 for keys, 3 for a stylus
    #[serde(default = "one")]
    pub axes: u32,
    /// least and largest position \[m\]
    pub range: [f64; 2],
    /// largest force of a vector \[N\]
    pub force: f64,
    /// largest force for ever \[N\], the peak where absent
    pub continuous: Option<f64>,
    /// largest stiffness it renders \[N/m\], absent where not known
    pub stiffness: Option<f64>,
    /// largest viscosity it renders \[N s/m\], absent where not known
    pub damping: Option<f64>,
    /// frames a second
    #[serde(default = "rate")]
    pub rate: f64,
    /// body: what moves with the hand
    #[serde(default)]
    pub body: Body,
    /// numbers of the guard
    #[serde(default)]
    pub guard: Limits,
}

/// Shortest time in which a force may begin or fade in \[s\].
const SOON: f64 = 0.01;

fn one() -> u32 {
    1
}

fn rate() -> f64 {
    3000.0
}

/// The mechanics of a device: what `ca device sim` simulates and `ca check --device` asks of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// moving mass \[kg\]
    pub mass: f64,
    /// viscous friction \[N s/m\]
    pub friction: f64,
    /// dry friction \[N\]
    pub dry: f64,
    /// step of the position sensor \[m\]; 0 for none
    pub step: f64,
    /// noise of the position sensor, rms \[m\]
    pub noise: f64,
    /// step of the force output \[N\]; 0 for none
    pub force_step: f64,
}

impl Default for Body {
    fn default() -> Body {
        Body { mass: 0.1, friction: 2.0, dry: 0.0, step: 0.0, noise: 0.0, force_step: 0.0 }
    }
}

/// Numbers of the guard (haptics H1 to H16), with the defaults of the requirements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// fastest motion before the velocity trip \[m/s\] (H9)
    pub speed: f64,
    /// largest change of force a second \[N/s\]; absent: stiffness times `speed` (H3)
    pub slew: Option<f64>,
    /// time over which force is averaged for the thermal budget \[s\] (H4)
    pub thermal: f64,
    /// part of the largest force that counts as "nothing pushes" (H5)
    pub clear: f64,
    /// how long nothing must push before forces begin \[s\] (H5)
    pub clear_time: f64,
    /// time to fade forces in \[s\] (H5)
    pub ramp: f64,
    /// in how long the scene crosses the travel to where a device is when it appears \[s\]
    pub approach: f64,
    /// how long the force is held without fresh frames \[s\]; absent: 1 ms, or two frames of a slower device (H6)
    pub hold: Option<f64>,
    /// when it has reached zero \[s\] (H6)
    pub zero: f64,
    /// life of a force frame at the device \[s\] (H7)
    pub ttl: f64,
    /// viscosity of the damped stop \[N s/m\] (H9)
    pub brake: f64,
    /// its length \[s\] (H9)
    pub stop: f64,
    /// bad frames within `bad_time` that make a fault (H10)
    pub bad: u32,
    /// \[s\] (H10)
    pub bad_time: f64,
    /// part of the travel at each end that is softly closed (H11)
    pub edge: f64,
    /// stiffness of the soft edge \[N/m\]; absent: see [`Profile::edge_stiffness`] (H11)
    pub edge_stiffness: Option<f64>,
    /// the passivity stage (H12)
    pub passivity: bool,
    /// largest viscosity it adds, as a part of `body.friction` (H12)
    pub passivity_viscosity: f64,
    /// largest force it adds, as a part of the largest force (H12)
    pub passivity_force: f64,
    /// frequency up to which it follows the motion \[Hz\] (H12)
    pub passivity_band: f64,
    /// largest energy it accounts as made by the rate boundary \[J\] (H12)
    pub passivity_leak: f64,
    /// the oscillation detector (H13)
    pub oscillation: bool,
    /// part of the largest force, in the band, that counts as an oscillation (H13)
    pub oscillation_level: f64,
    /// its band \[Hz\]; `inf` for up to half of the gesture rate (H13)
    pub oscillation_band: [f64; 2],
    /// how long it must last \[s\], the first time and to be weakened again (H13)
    pub oscillation_time: f64,
    /// gain once detected, again for as long as it goes on (H13)
    pub oscillation_gain: f64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            speed: 1.0,
            slew: None,
            thermal: 1.0,
            clear: 0.05,
            clear_time: 0.1,
            ramp: 1.0,
            approach: 1.0,
            hold: None,
            zero: 0.01,
            ttl: 0.005,
            brake: 5.0,
            stop: 0.2,
            bad: 10,
            bad_time: 0.1,
            edge: 0.05,
            edge_stiffness: None,
            passivity: true,
            passivity_viscosity: 0.5,
            passivity_force: 0.1,
            passivity_band: 60.0,
            passivity_leak: 2e-4,
            oscillation: true,
            oscillation_level: 0.3,
            oscillation_band: [30.0, f64::INFINITY],
            oscillation_time: 0.05,
            oscillation_gain: 0.3,
        }
    }
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        /// The profiles that come with us: name and text.
        pub const SHIPPED: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../profiles/", $name, ".toml")))),*];
    };
}
shipped!(
    "unknown",
    "tgr12",
    "falcon",
    "omega3",
    "delta3",
    "sigma7",
    "lambda7",
    "touch",
    "omni",
    "phantom-desktop",
    "premium3.0",
    "inverse3",
    "firefader",
    "mouse",
);

impl Profile {
    /// Reads a profile. `file` is named in errors.
    pub fn read(text: &str, file: &str) -> Result<Profile, FileError> {
        let bad = |what: String| FileError::new(FileErrorKind::Content, format!("{file}: {what}"));
        let p: Profile = toml::from_str(text).map_err(|e| bad(e.to_string().trim_end().into()))?;
        p.sense().map_err(bad)?;
        Ok(p)
    }

    /// A profile that comes with us.
    pub fn shipped(name: &str) -> Option<Profile> {
        let (_, text) = SHIPPED.iter().find(|s| s.0 == name)?;
        Profile::read(text, name).ok()
    }

    /// Text of this profile, as [`Profile::read`] takes it.
    pub fn write(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// The first thing about it that makes no sense.
    fn sense(&self) -> Result<(), String> {
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

    /// Largest change of force a second \[N/s\] (H3).
    pub fn slew(&self) -> f64 {
        self.guard.slew.unwrap_or(self.stiffness.unwrap_or(1000.0) * self.guard.speed)
    }

    /// Stiffness of the soft edge \[N/m\] (H11): half of what the device renders, or what reaches the largest force at
    /// the end stop, whichever is less.
    pub fn edge_stiffness(&self) -> f64 {
        let width = self.guard.edge * (self.range[1] - self.range[0]);
        let whole = if width > 0.0 { self.force / width } else { 0.0 };
        self.guard.edge_stiffness.unwrap_or_else(|| self.stiffness.map_or(whole, |k| whole.min(0.5 * k)))
    }

    /// Smallest motion that is no error of the sensor \[m\]: its step, and six standard deviations of its noise.
    pub fn grain(&self) -> f64 {
        self.body.step + 6.0 * self.body.noise
    }

    /// How long the force is held without fresh frames \[s\] (H6).
    pub fn hold(&self) -> f64 {
        self.guard.hold.unwrap_or_else(|| (2.0 / self.rate).max(0.001))
    }

    /// Largest force for ever \[N\].
    pub fn continuous(&self) -> f64 {
        self.continuous.unwrap_or(self.force)
    }
}
