//! Backward pass over outputs: from adjoints of samples to adjoints of positions, motions and forces.

use crate::parts::outputs::{Listed, listed};
use crate::parts::record::Row;
use ca_core::Scene;
use ca_core::internal::op::layout::{DcBlocker, Tap};

struct OutputState {
    channel: usize,
    tap: Tap,
    gain: f64,
    /// Index of the gain into the coefficients.
    at: usize,
    motion: bool,
    /// Index and filter of its high pass.
    high_pass: Option<(usize, DcBlocker)>,
    /// Adjoint of the high pass at the next tick.
    kept: f64,
}

pub struct Outputs {
    all: Vec<OutputState>,
    /// First half of the low-pass, including its middle.
    low_pass: Vec<f64>,
    channels: usize,
    n_out: usize,
}

/// Adjoint of a value read by an output at one tick.
pub enum OutputAdjoint {
    Place(usize, f64),
    Motion(usize, f64),
    /// Sum of the forces on a slot.
    Sum(usize, f64),
    /// Force of a link, by its tap.
    Force(usize, f64),
    /// r and g of a high pass, by its index.
    HighPass(usize, [f64; 2]),
}

impl Outputs {
    pub fn of(scene: &Scene) -> Outputs {
        let l = &scene.layout;
        let state = |o: Listed| OutputState {
            channel: o.channel,
            tap: o.tap,
            gain: scene.initial.coef[o.gain],
            at: o.gain,
            motion: o.motion,
            high_pass: o.high_pass.map(|k| (k, l.out.blockers[k])),
            kept: 0.0,
        };
        Outputs {
            all: listed(scene).map(state).collect(),
            low_pass: l.out.lowpass.clone(),
            channels: l.counts.channels,
            n_out: l.counts.n_out,
        }
    }

    /// Returns the adjoints of the channels before their low-pass (frames x outputs).
    pub fn before_low_pass(&self, cotangent: &[f64]) -> Vec<f64> {
        let mut all = cotangent.to_vec();
        let Some((middle, sides)) = self.low_pass.split_last() else { return all };
        let (frames, n) = (cotangent.len() / self.n_out.max(1), 2 * sides.len() + 1);
        for channel in 0..self.channels {
            let of = |frame: usize| if frame < frames { cotangent[frame * self.n_out + channel] } else { 0.0 };
            for frame in 0..frames {
                let each = sides.iter().enumerate().map(|(k, h)| h * (of(frame + k) + of(frame + n - 1 - k)));
                all[frame * self.n_out + channel] = middle * of(frame + sides.len()) + each.sum::<f64>();
            }
        }
        all
    }

    /// Goes back one tick with the adjoints of its samples (outputs). `to` receives the adjoints of the values read,
    /// `gains` an adjoint for the index of each gain.
    pub fn back(
        &mut self,
        tick: usize,
        adjoint: &[f64],
        row: &Row,
        mut to: impl FnMut(OutputAdjoint),
        mut gains: impl FnMut(usize, f64),
    ) {
        let mut forces = row.output_forces.iter();
        for h in &mut self.all {
            let mut v = adjoint[h.channel];
            let mut to_filter = 0.0;
            if let Some((_, c)) = h.high_pass {
                // before the first tick, the input is taken to have been constant
                let now = if tick > 0 { v + c.r * h.kept } else { 0.0 };
                v = c.g * (now - h.kept);
                (h.kept, to_filter) = (now, now);
            }
            let (raw, adjoint) = match h.tap {
                Tap::Position(m) if h.motion => (row.d[m as usize], OutputAdjoint::Motion(m as usize, h.gain * v)),
                Tap::Position(m) => (row.x[m as usize], OutputAdjoint::Place(m as usize, h.gain * v)),
                Tap::ForceOn(m) => (forces.next().copied().unwrap_or(0.0), OutputAdjoint::Sum(m as usize, h.gain * v)),
                Tap::ForceOf(t) => {
                    (forces.next().copied().unwrap_or(0.0), OutputAdjoint::Force(t as usize, h.gain * v))
                }
            };
            gains(h.at, v * raw);
            to(adjoint);
            if let Some((k, _)) = h.high_pass.filter(|_| to_filter != 0.0) {
                if let Some([before, y]) = row.passed.get(2 * k..).and_then(|p| p.first_chunk::<2>()) {
                    to(OutputAdjoint::HighPass(k, [to_filter * y, to_filter * (h.gain * raw - before)]));
                }
            }
        }
    }
}
