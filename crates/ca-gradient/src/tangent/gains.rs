//! Derivatives of outputs by their gains, where a parameter changes these.

use crate::parts::number;
use crate::parts::outputs::{Listed, listed};
use crate::parts::record::Row;
use ca_core::internal::op::layout::Tap;
use ca_core::{Scene, State};

/// Output whose gain some parameter changes.
struct Gain {
    channel: usize,
    tap: Tap,
    motion: bool,
    /// Index among the forces read by outputs.
    force: usize,
    /// Derivatives of its gain (parameters).
    by: Vec<f64>,
}

pub struct Gains(Vec<Gain>);

impl Gains {
    /// Returns the gains that parameters change; `columns` are the derivatives of the numbers.
    pub fn new(scene: &Scene, place: &Scene, columns: &[&[f64]]) -> Gains {
        let gain = |o: Listed| {
            let by = columns.iter().map(|column| column[number(place.initial.coef[o.gain])]).collect();
            Gain { channel: o.channel, tap: o.tap, motion: o.motion, force: o.forces, by }
        };
        let without = listed(scene).filter(|o| o.high_pass.is_none());
        Gains(without.map(gain).filter(|g| g.by.iter().any(|v| *v != 0.0)).collect())
    }

    pub fn is_idle(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds to the outputs of the derivatives by parameter `q` in a tick that began with `row`.
    pub fn add(&self, row: &Row, q: usize, to: &mut State) {
        for g in &self.0 {
            let raw = match g.tap {
                Tap::Position(m) if g.motion => row.d[m as usize],
                Tap::Position(m) => row.x[m as usize],
                Tap::ForceOn(_) | Tap::ForceOf(_) => row.output_forces[g.force],
            };
            to.output[g.channel] += g.by[q] * raw;
        }
    }
}
