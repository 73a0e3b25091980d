//! Equivalence: how large and how heavy the simulated world is in the hand.
//!
//! X = α·x converts a real to a simulated position, and f = β·F a simulated to a real force (GENESIS paper, 6.3;
//! docs/numerics.md §6). The table and its syntax in a model are in [`ca_core::equivalence`]. This module returns what
//! a device needs of it: two numbers per degree of freedom.

use ca_core::Scene;
pub use ca_core::equivalence::Gains;

/// Returns the gains of each degree of freedom of `device`; 1:1 where it moves nothing in the scene.
pub fn gains(scene: &Scene, device: &str) -> Vec<Gains> {
    let mut all: Vec<Gains> = Vec::new();
    for i in &scene.inputs {
        let Some((_, dof)) = i.device.as_ref().filter(|d| d.0 == device) else { continue };
        let dof = *dof as usize;
        if all.len() <= dof {
            all.resize(dof + 1, Gains::default());
        }
        all[dof] = i.gains;
    }
    all
}
