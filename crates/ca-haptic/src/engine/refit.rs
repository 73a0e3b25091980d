//! Replaces the port of a device that describes itself only when the engine is running.
//!
//! The new port is made outside the engine and replaces the old one between two gesture frames, like a reload: the
//! description determines the stages of the guard, and making them allocates. The position of the port in the scene,
//! the number of the force frame and the arming continue. Forces that were on end in a fault, because they were for
//! another device.

use super::port::{Port, Setup};
use crate::frame::{Cause, Mode};
use crate::guard::Order;
use crate::profile::Profile;
use ca_core::Scene;

/// A port that replaces another. A clone is only for the record: it contains number and profile, but not the port.
pub struct Refit {
    /// Number of the device in the engine.
    pub which: u32,
    /// New profile of the device.
    pub profile: Profile,
    port: Option<Port>,
}

impl Refit {
    /// Makes the new port of device number `which`, from `setup`.
    pub fn new(scene: &Scene, which: u32, setup: Setup) -> Refit {
        Refit { which, profile: setup.profile.clone(), port: Some(Port::new(scene, setup)) }
    }

    /// Exchanges the ports without allocating. Returns the number of faults of the old port; `None` for a clone.
    pub(super) fn swap(&mut self, old: &mut Port) -> Option<u64> {
        let new = self.port.as_mut()?;
        if old.chain.is_armed() {
            new.chain.order(Order::Arm);
        }
        if !matches!(old.hand.mode, Mode::Off | Mode::Fault) {
            new.chain.order(Order::Trip(Cause::Disconnect));
        }
        new.follow(old);
        core::mem::swap(new, old);
        Some(new.chain.faults())
    }
}

impl Clone for Refit {
    fn clone(&self) -> Refit {
        Refit { which: self.which, profile: self.profile.clone(), port: None }
    }
}

impl PartialEq for Refit {
    fn eq(&self, other: &Refit) -> bool {
        (self.which, &self.profile) == (other.which, &other.profile)
    }
}

impl core::fmt::Debug for Refit {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Refit").field("which", &self.which).field("profile", &self.profile).finish_non_exhaustive()
    }
}
