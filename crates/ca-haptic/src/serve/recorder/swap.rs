//! Another version of the scene, as the recorder knows it: made ready, on its way, and there.
//!
//! Decides that live parameters that somebody has moved stay where they are, and those that nobody has are as the new version
//! says: who edits a value wants to hear it.

use super::super::picture;
use super::{Recorder, Refused, hand};
use crate::engine::{EngineCommand, Setup, Swap};
use crate::version::{self, Version};
use ca_core::{LiveParam, Scene};
use std::sync::Arc;

/// Pictures of a new version that the ring must have room for.
const PICTURES: usize = 8;

impl Recorder {
    /// Another version of the scene plays from the next gesture frame on: masses of the same name go on from where they are.
    ///
    /// # Errors
    /// If the two differ in what cannot change while it plays, or the engine takes no order.
    pub fn swap(&mut self, mut version: Version, setups: &[Setup]) -> Result<(), Refused> {
        let scene = version.scene.clone();
        let room = self.ends.views.as_ref().map(|v| v.buffer().capacity());
        if room.is_some_and(|room| room < PICTURES * picture(&scene)) {
            return Err(Refused::Large);
        }
        let (load, new) = (self.scene.controls(), scene.controls());
        let moved = self.controls.params().iter().zip(load.params()).filter(|(now, load)| now.value != load.value);
        let fits = |now: &LiveParam| new.params().iter().any(|p| p.name == now.name && p.unit.dim.same(now.unit.dim));
        version.moved = moved.filter(|(now, _)| fits(now)).map(|(now, _)| (now.name.clone(), now.value)).collect();
        let (state, controls) = version::begin(&scene, &version.moved);
        let swap = Swap::new(&self.scene, scene, state, setups, (self.versions + 1, version.anew))?;
        self.command(EngineCommand::Swap(Box::new(swap)))?;
        self.versions += 1;
        self.coming = Some((Arc::new(version), controls));
        Ok(())
    }

    /// Whether a version is on its way to the engine: who asks something of the scene has to wait a few milliseconds.
    pub fn is_swapping(&self) -> bool {
        self.coming.is_some()
    }

    /// The scene that plays, or is about to.
    pub fn scene(&self) -> &Arc<Scene> {
        self.coming.as_ref().map_or(&self.scene, |c| &c.0.scene)
    }

    /// The engine plays it.
    pub(super) fn swapped(&mut self, tick: u64) {
        let Some((version, controls)) = self.coming.take() else { return };
        self.hand = hand::Hand::new(&version.scene);
        (self.scene, self.controls) = (version.scene.clone(), controls);
        self.tell(|s| s.swapped(tick, &version));
    }
}
