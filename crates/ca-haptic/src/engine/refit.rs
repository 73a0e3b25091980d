//! A device that says what it is only once the engine runs: its port made anew.
//!
//! Decides that the new port is made outside and put in its place between two gesture frames, like a reload, since
//! stages are sized by what the device is and making them allocates. What the scene and the wire know goes on: where the
//! port of the scene is, the number of the force frame, whether somebody has armed it. Forces never go on: where they
//! were on they end in a fault, for they were those of another device.

use super::port::{Port, Setup};
use crate::frame::{Cause, Mode};
use crate::guard::Order;
use crate::profile::Profile;
use ca_core::Scene;

/// A port to put in the place of another. A copy knows which and what, for the record, and has no port to give.
pub struct Refit {
    /// number of the device in the engine
    pub which: u32,
    /// what the device is from now on
    pub profile: Profile,
    port: Option<Port>,
}

impl Refit {
    /// For device number `which`, whose setup becomes `setup`.
    pub fn new(scene: &Scene, which: u32, setup: Setup) -> Refit {
        Refit { which, profile: setup.profile.clone(), port: Some(Port::new(scene, setup)) }
    }

    /// Changes places with `old`. Nothing allocates. Gives how many faults `old` had; `None` where there is no port to
    /// give.
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
