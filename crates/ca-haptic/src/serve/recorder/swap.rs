//! Sends another version of the scene to the engine, and follows it when it plays.
//!
//! A live parameter that was changed retains its value. The others take their values from the new version, so that an
//! edit of a value is audible.

use super::super::picture;
use super::{Recorder, Refused, manual};
use crate::engine::{EngineCommand, Setup, Swap};
use crate::version::{self, Version};
use ca_core::{LiveParam, Scene};
use std::sync::Arc;

/// Pictures of a new version that must fit in the ring.
const PICTURES: usize = 8;

impl Recorder {
    /// Plays another version of the scene from the next gesture frame on; masses with the same name continue.
    ///
    /// # Errors
    /// If the versions differ in a part that cannot change while it plays, the new one is too large, or the engine does
    /// not take commands now.
    pub fn swap(&mut self, mut version: Version, setups: &[Setup]) -> Result<(), Refused> {
        let scene = version.scene.clone();
        let capacity = self.ends.views.as_ref().map(|v| v.buffer().capacity());
        if capacity.is_some_and(|capacity| capacity < PICTURES * picture(&scene)) {
            return Err(Refused::Large);
        }
        let (load, new) = (self.scene.controls(), scene.controls());
        let moved = self.controls.params().iter().zip(load.params()).filter(|(now, load)| now.value != load.value);
        let fits = |now: &LiveParam| new.params().iter().any(|p| p.name == now.name && p.unit.dim.same(now.unit.dim));
        version.moved = moved.filter(|(now, _)| fits(now)).map(|(now, _)| (now.name.clone(), now.value)).collect();
        let (state, controls) = version::begin(&scene, &version.moved);
        let swap = Swap::new(&self.scene, scene, state, setups, (self.versions + 1, version.restart))?;
        self.command(EngineCommand::Swap(Box::new(swap)))?;
        self.versions += 1;
        self.pending = Some((Arc::new(version), controls));
        Ok(())
    }

    /// Returns true while a version is on its way to the engine; commands to the scene must wait some milliseconds.
    pub fn is_swapping(&self) -> bool {
        self.pending.is_some()
    }

    /// Returns the scene that plays, or is about to.
    pub fn scene(&self) -> &Arc<Scene> {
        self.pending.as_ref().map_or(&self.scene, |c| &c.0.scene)
    }

    /// Notes that the engine plays the new version.
    pub(super) fn swapped(&mut self, tick: u64) {
        let Some((version, controls)) = self.pending.take() else { return };
        self.manual = manual::ManualProgress::new(&version.scene);
        (self.scene, self.controls) = (version.scene.clone(), controls);
        self.for_each_sink(|s| s.swapped(tick, &version));
    }
}
