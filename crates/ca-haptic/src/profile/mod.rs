//! Device profiles: every number that protects a hand, in one text file per device.
//!
//! Decides that no number of the guard stands in code: `profiles/<name>.toml` holds what is known of the device with
//! its source, and what the guard uses of it by default ([`Limits`]); a file of the user's own overrides any of them.
//! A device nobody has described is `unknown`: 2 N, slow, soft, of as many degrees of freedom as it says it has.

mod described;
mod fault;
mod sense;
#[cfg(test)]
mod tests;

pub use described::UNKNOWN;
pub use fault::ProfileFault;

use ca_io::error::{FileError, FileErrorKind};
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
    /// keys that are stiffer than the device holds are softened ([`crate::coupling`])
    pub coupling: bool,
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
            coupling: true,
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
    ///
    /// # Errors
    /// With the line and its bounds, for the first entry that is none.
    pub fn read(text: &str, file: &str) -> Result<Profile, FileError> {
        let bad = |what: String| FileError::new(FileErrorKind::Content, format!("{file}: {what}"));
        let p: Profile = toml::from_str(text).map_err(|e| bad(e.to_string().trim_end().into()))?;
        p.sense().map_err(|fault| bad(fault.to_string()))?;
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
