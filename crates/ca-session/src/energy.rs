//! Kinetic energy for the page.
//!
//! The energy is computed from the pictures, since a scene has an energy ledger only on request. The sums are by the
//! names that the author of the model wrote, such as a string or a hammer.

use ca_core::{Location, Scene};

/// Largest number of names; masses of further names count under the last.
const NAMES: usize = 6;

/// Masses of a scene, summed by name.
pub(crate) struct KineticEnergy {
    names: Vec<String>,
    /// Index in the state, index of the sum, and ½ m/T² \[J/m²\] at load.
    masses: Vec<(usize, usize, f64)>,
}

impl KineticEnergy {
    /// Takes all masses of a scene that can move.
    pub(crate) fn new(scene: &Scene) -> KineticEnergy {
        let (mut names, mut masses): (Vec<String>, _) = (Vec::new(), Vec::new());
        let mut more = false;
        for k in 0..scene.mats() {
            let Some(symbol) = scene.symbols.get(k) else { continue };
            let Location::Mat(at) = symbol.location else { continue };
            let places = at as usize..at as usize + if symbol.axes > 1 { 3 } else { 1 };
            // C = T²/m; 0 for a MAT that no force moves
            let of = |p: usize| scene.initial.coef.get(2 * scene.counts.n_mat + p).filter(|c| **c > 0.0);
            let moves: Vec<(usize, f64)> = places.filter_map(|p| Some((p, 0.5 / *of(p)?))).collect();
            if moves.is_empty() {
                continue;
            }
            let name = symbol.name.to_string();
            let name = name.split('[').next().unwrap_or_default();
            let sum = names.iter().position(|n| n == name).unwrap_or_else(|| {
                if names.len() < NAMES {
                    names.push(name.into());
                } else {
                    more = true;
                }
                names.len() - 1
            });
            masses.extend(moves.into_iter().map(|(p, half)| (p, sum, half)));
        }
        if let (true, Some(last)) = (more, names.last_mut()) {
            last.push_str(" and others");
        }
        KineticEnergy { names, masses }
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the energy of each sum \[J\]; `d` has the displacements in a tick \[m\].
    pub(crate) fn of(&self, d: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.names.len()];
        for (place, sum, half) in &self.masses {
            let d = d.get(*place).copied().unwrap_or(0.0);
            sums[*sum] += half * d * d;
        }
        sums
    }
}
