//! Equivalence: how large and how heavy the simulated world is in the hand.
//!
//! X = α·x from real to simulated position, f = β·F from simulated to real force (GENESIS paper, 6.3;
//! docs/numerics.md §6). The table, and what an author writes about it, are of the model: [`ca_core::equivalence`].
//! Here is what a device needs of it, which is two numbers for each of its degrees of freedom.

use ca_core::Scene;
pub use ca_core::equivalence::Gains;

/// The gains of each degree of freedom of `device`, as the model says; one to one where nothing of the scene moves with
/// it.
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
