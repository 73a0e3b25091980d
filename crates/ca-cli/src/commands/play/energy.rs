//! Energy of motion, as the page shows it.
//!
//! Decides that it is had from the pictures and not from the ledger, which a scene keeps only where that is asked; and that it is
//! summed by the name of what the author wrote, a string or a hammer, since that is what somebody watches.

use ca_core::Scene;
use ca_core::scene::Location;

/// Names that are told apart; the last takes what there is more.
const NAMES: usize = 6;

/// Masses, and whose they are.
pub(super) struct KineticEnergy {
    names: Vec<String>,
    /// places in the state, which sum, and ½ m/T² \[J/m²\] at load
    masses: Vec<(usize, usize, f64)>,
}

impl KineticEnergy {
    /// Of what can move in a scene.
    pub(super) fn new(scene: &Scene) -> KineticEnergy {
        let (mut names, mut masses): (Vec<String>, _) = (Vec::new(), Vec::new());
        let mut more = false;
        for k in 0..scene.mats() {
            let Some(symbol) = scene.symbols.get(k) else { continue };
            let Location::Mat(at) = symbol.location else { continue };
            let places = at as usize..at as usize + if symbol.axes > 1 { 3 } else { 1 };
            // C = T²/m; 0 of what no force moves
            let of = |p: usize| scene.initial.coef.get(2 * scene.n_mat + p).filter(|c| **c > 0.0);
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

    /// Of each sum, its name.
    pub(super) fn names(&self) -> &[String] {
        &self.names
    }

    /// Of each sum \[J\], given the displacements in a tick \[m\].
    pub(super) fn of(&self, d: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.names.len()];
        for (place, sum, half) in &self.masses {
            let d = d.get(*place).copied().unwrap_or(0.0);
            sums[*sum] += half * d * d;
        }
        sums
    }
}
