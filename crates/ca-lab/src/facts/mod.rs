//! Describes a scene in words for every front end: modules, ports, border, stability, energy and loudness.

pub mod border;
pub mod certificate;
pub mod energy;
pub mod inputs;
pub mod level;
pub mod modes;

use ca_core::Scene;

/// Counts the running modules of each code, in order of first appearance.
pub fn codes(scene: &Scene) -> Vec<(&'static str, usize)> {
    let mut list: Vec<(&'static str, usize)> = Vec::new();
    for s in &scene.symbols {
        match list.iter_mut().find(|c| c.0 == s.code) {
            Some(c) => c.1 += 1,
            None => list.push((s.code, 1)),
        }
    }
    list
}
