//! Device profiles: properties and guard limits of a device, in one text file.
//!
//! `profiles/<name>.toml` holds the known properties of a device with their source, and the limits of its guard
//! ([`Limits`]); a file of the user overrides any number. A device without a profile is `unknown`: 2 N, slow, soft,
//! with as many degrees of freedom as it reports.

mod fault;
mod from_description;
#[cfg(test)]
mod tests;
mod validate;

pub use fault::ProfileFault;
pub use from_description::UNKNOWN;

use ca_io::error::{FileError, FileErrorKind};
use serde::{Deserialize, Serialize};

/// Properties of a device for the guard and the simulation, per degree of freedom unless stated otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// Name, as in `--profile`.
    pub name: String,
    /// Make and model.
    pub title: String,
    /// Source of the numbers.
    pub source: String,
    /// Degrees of freedom, at most 32.
    pub dof: u32,
    /// Number of neighbouring DOF in one force vector: 1 for keys, 3 for a stylus.
    #[serde(default = "one")]
    pub axes: u32,
    /// Least and largest position \[m\].
    pub range: [f64; 2],
    /// Largest force of a vector \[N\].
    pub force: f64,
    /// Largest continuous force \[N\]; `force` if absent.
    pub continuous: Option<f64>,
    /// Largest stiffness that it renders \[N/m\]; absent if not known.
    pub stiffness: Option<f64>,
    /// Largest viscosity that it renders \[N s/m\]; absent if not known.
    pub damping: Option<f64>,
    /// Frames a second.
    #[serde(default = "rate")]
    pub rate: f64,
    /// Mechanics of the part that moves with the hand.
    #[serde(default)]
    pub body: Body,
    /// Limits of the guard.
    #[serde(default)]
    pub guard: Limits,
}

fn one() -> u32 {
    1
}

fn rate() -> f64 {
    3000.0
}

/// Mechanics of a device, for `ca device sim`, `ca check --device` and the passivity stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// Moving mass \[kg\].
    pub mass: f64,
    /// Viscous friction \[N s/m\].
    pub friction: f64,
    /// Dry friction \[N\].
    pub dry: f64,
    /// Step of the position sensor \[m\]; 0 for none.
    pub step: f64,
    /// Noise of the position sensor, r.m.s. \[m\].
    pub noise: f64,
    /// Step of the force output \[N\]; 0 for none.
    pub force_step: f64,
}

impl Default for Body {
    fn default() -> Body {
        Body { mass: 0.1, friction: 2.0, dry: 0.0, step: 0.0, noise: 0.0, force_step: 0.0 }
    }
}

/// Limits of the guard (haptics H1 to H16), with the defaults of the requirements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Limits {
    /// Speed of the velocity trip \[m/s\] (H9).
    pub speed: f64,
    /// Largest change of force a second \[N/s\]; if absent, stiffness times `speed` (H3).
    pub slew: Option<f64>,
    /// Time over which the thermal budget averages the force \[s\] (H4).
    pub thermal: f64,
    /// Part of the largest force below which nothing pushes (H5).
    pub clear: f64,
    /// Time for which nothing must push before forces begin \[s\] (H5).
    pub clear_time: f64,
    /// Duration of the fade-in \[s\] (H5).
    pub ramp: f64,
    /// Time in which the scene would cross the whole travel, on its way to a device that appears \[s\].
    pub approach: f64,
    /// Time for which the force is held without fresh frames \[s\]; if absent, 1 ms or two device frames (H6).
    pub hold: Option<f64>,
    /// Time without fresh frames at which the force has reached zero \[s\] (H6).
    pub zero: f64,
    /// Time to live of a force frame at the device \[s\] (H7).
    pub ttl: f64,
    /// Viscosity of the damped stop \[N s/m\] (H9).
    pub brake: f64,
    /// Duration of the damped stop \[s\] (H9).
    pub stop: f64,
    /// Number of bad frames within `bad_time` that make a fault (H10).
    pub bad: u32,
    /// Time in which bad frames are counted \[s\] (H10).
    pub bad_time: f64,
    /// Part of the travel at each end that is a soft edge (H11).
    pub edge: f64,
    /// Stiffness of the soft edge \[N/m\]; if absent, see [`Profile::edge_stiffness`] (H11).
    pub edge_stiffness: Option<f64>,
    /// Turns the passivity stage on (H12).
    pub passivity: bool,
    /// Largest viscosity that it adds, as a part of `body.friction` (H12).
    pub passivity_viscosity: f64,
    /// Largest force that it adds, as a part of the largest force (H12).
    pub passivity_force: f64,
    /// Frequency up to which it follows the motion \[Hz\] (H12).
    pub passivity_band: f64,
    /// Largest energy that it counts as made by the rate boundary \[J\] (H12).
    pub passivity_leak: f64,
    /// Softens keys that are stiffer than the device can render ([`crate::coupling`]).
    pub coupling: bool,
    /// Turns the oscillation detector on (H13).
    pub oscillation: bool,
    /// Level in the band that counts as an oscillation, as a part of the largest force (H13).
    pub oscillation_level: f64,
    /// Band of the detector \[Hz\]; `inf` means up to half of the gesture rate (H13).
    pub oscillation_band: [f64; 2],
    /// Time for which an oscillation must last before the force is weakened, each time \[s\] (H13).
    pub oscillation_time: f64,
    /// Gain applied when an oscillation is detected, and again while it goes on (H13).
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
        /// Profiles included in the program: name and text.
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
    /// Parses a profile. `file` is the name used in errors.
    ///
    /// # Errors
    /// Names the line or the bounds of the first invalid entry.
    pub fn read(text: &str, file: &str) -> Result<Profile, FileError> {
        let bad = |what: String| FileError::new(FileErrorKind::Content, format!("{file}: {what}"));
        let p: Profile = toml::from_str(text).map_err(|e| bad(e.to_string().trim_end().into()))?;
        p.sense().map_err(|fault| bad(fault.to_string()))?;
        Ok(p)
    }

    /// Returns an included profile.
    pub fn shipped(name: &str) -> Option<Profile> {
        let (_, text) = SHIPPED.iter().find(|s| s.0 == name)?;
        Profile::read(text, name).ok()
    }

    /// Returns the profile as text that [`Profile::read`] parses.
    pub fn write(&self) -> String {
        toml::to_string(self).unwrap_or_default()
    }

    /// Returns the largest change of force a second \[N/s\] (H3).
    pub fn slew(&self) -> f64 {
        self.guard.slew.unwrap_or(self.stiffness.unwrap_or(1000.0) * self.guard.speed)
    }

    /// Returns the stiffness of the soft edge \[N/m\] (H11).
    ///
    /// By default it is half of what the device renders, or reaches the largest force at the stop, whichever is softer.
    pub fn edge_stiffness(&self) -> f64 {
        let width = self.guard.edge * (self.range[1] - self.range[0]);
        let whole = if width > 0.0 { self.force / width } else { 0.0 };
        self.guard.edge_stiffness.unwrap_or_else(|| self.stiffness.map_or(whole, |k| whole.min(0.5 * k)))
    }

    /// Returns the smallest motion that is not sensor error \[m\]: its step plus six standard deviations of its noise.
    pub fn grain(&self) -> f64 {
        self.body.step + 6.0 * self.body.noise
    }

    /// Returns the time for which the force is held without fresh frames \[s\] (H6).
    pub fn hold(&self) -> f64 {
        self.guard.hold.unwrap_or_else(|| (2.0 / self.rate).max(0.001))
    }

    /// Returns the largest continuous force \[N\].
    pub fn continuous(&self) -> f64 {
        self.continuous.unwrap_or(self.force)
    }
}
