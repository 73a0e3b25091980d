//! Admission of a device without a profile: decides from its own description whether a scene may be played with it.

use crate::coupling;
use crate::engine::Setup;
use crate::frame::About;
use crate::profile::{Profile, ProfileFault};
use ca_core::{Input, Scene, Unit};
use ca_model::quantity::{show, six};
use std::fmt;

/// Reason why a scene is not played with a device that describes itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NotAdmitted {
    /// The description of the device is impossible.
    Profile(ProfileFault),
    /// The device has fewer degrees of freedom than the scene uses.
    Freedom {
        /// Degrees of freedom of the device.
        has: u32,
        /// Degrees of freedom that the scene uses.
        wanted: u32,
    },
    /// A key is stiffer in the hand than the device can render.
    Stiff {
        /// The key.
        key: String,
        /// Its stiffness \[N/m\].
        stiffness: f64,
    },
}

impl fmt::Display for NotAdmitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotAdmitted::Profile(fault) => fault.fmt(f),
            NotAdmitted::Freedom { has, wanted } => {
                write!(
                    f,
                    "the model needs {wanted} degrees of freedom, but the device has {has}; the device is not used"
                )
            }
            NotAdmitted::Stiff { key, stiffness } => {
                let k = show(six(*stiffness), Unit::STIFFNESS);
                write!(
                    f,
                    "`{key}` has a stiffness of {k} in the hand, more than the limit that the device reports; the \
                     device is not used; describe it in a profile (`--profile`)"
                )
            }
        }
    }
}

impl std::error::Error for NotAdmitted {}

/// A device without a profile, which has to describe itself.
#[derive(Clone, Debug)]
pub struct DeviceWithoutProfile {
    /// Upper limits for such a device.
    pub most: Profile,
    /// Degrees of freedom that the scene uses.
    pub wanted: u32,
}

impl DeviceWithoutProfile {
    /// Fits the setup to the description of the device and returns that description in words.
    ///
    /// Returns `None` where the setup already matches.
    ///
    /// # Errors
    /// [`NotAdmitted`]; the setup is unchanged then.
    pub fn fit(&self, setup: &mut Setup, about: &About, scene: &Scene) -> Result<Option<String>, NotAdmitted> {
        let p = self.most.described(about).map_err(NotAdmitted::Profile)?;
        let of = |i: &Input| i.device.as_ref().is_some_and(|d| d.0 == setup.device && d.1 < p.dof);
        if p.dof < self.wanted && (p.axes > 1 || !scene.inputs.iter().any(of)) {
            return Err(NotAdmitted::Freedom { has: p.dof, wanted: self.wanted });
        }
        if p == setup.profile {
            return Ok(None);
        }
        let said = Setup { profile: p, ..setup.clone() };
        // the couplings were chosen for the limits known before
        if let Some((key, stiffness)) = coupling::beyond(scene, &said) {
            return Err(NotAdmitted::Stiff { key, stiffness });
        }
        *setup = said;
        let p = &setup.profile;
        let others = if p.dof < self.wanted {
            format!(
                "; the model has keys for {} degrees of freedom; only MIDI and gestures play the others",
                self.wanted
            )
        } else {
            String::new()
        };
        let vector = if p.axes > 1 { format!(", {} per force vector", p.axes) } else { String::new() };
        Ok(Some(format!(
            "it reports: {}, {} degrees of freedom{vector}, {} frames a second; at most {} N without a profile{others}",
            p.title, p.dof, p.rate, p.force
        )))
    }
}

/// Lists where the description of a device falls short of its profile. The guard acts by the profile.
pub fn differences(p: &Profile, a: &About) -> Vec<String> {
    let n = (a.n as usize).min(p.dof as usize);
    let least = a.force[..n].iter().copied().fold(f32::INFINITY, f32::min);
    let mut list = Vec::new();
    if u32::from(a.n) < p.dof {
        list.push(format!(
            "has {} degrees of freedom, but its profile `{}` has {}: its frames are ignored; use one with `dof = {}`",
            a.n, p.name, p.dof, a.n
        ));
    }
    if f64::from(least) < p.force * (1.0 - 1e-6) && least > 0.0 {
        list.push(format!("gives at most {least} N, but its profile `{}` has {} N", p.name, p.force));
    }
    if (f64::from(a.rate) / p.rate - 1.0).abs() > 0.05 {
        list.push(format!("sends {} frames a second, but its profile `{}` has {}", a.rate, p.name, p.rate));
    }
    list
}
