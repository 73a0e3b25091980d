//! How late a scene answers, and what that asks of a device.
//!
//! Decides to state what follows from the scene alone: the time to compute a frame, buffers of sound and the loop of a
//! host come on top. A frame is computed when its last position is known, so an answer is one frame late (the 0.33 ms
//! of the rattle); a spring on a key is felt with the delay κ·T of its mean force, held by the device
//! (docs/numerics.md §5.2), and that is what limits its stiffness.

use crate::numeric::Real;
use crate::op::layout::Layout;

/// Delays of a scene, all in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delays {
    /// a gesture frame, T
    pub frame: f64,
    /// from the position of the hand to the force that answers it
    pub force: f64,
    /// from the position of the hand to the sound
    pub sound: f64,
    /// the part of `sound` that the filter of the outputs takes
    pub filter: f64,
    /// mean delay of a spring on a key, κ·T: half a frame held by the device, half a frame more for a mean over two
    /// positions, and the frames of `latency`
    pub spring: f64,
}

/// The delays of a scene.
pub fn delays<R: Real>(layout: &Layout<R>) -> Delays {
    let frame = f64::from(layout.rates.ratio) * layout.rates.sample_dt;
    let late = f64::from(layout.ports.crossing.latency);
    let ahead = layout.ports.tgr.iter().any(|p| layout.ports.ahead.contains(&p.mat));
    let tick = if ahead { layout.rates.sample_dt / f64::from(layout.oversample()) } else { 0.0 };
    let force = frame * (1.0 + late) + tick;
    let filter =
        layout.out.lowpass.len().saturating_sub(1) as f64 * layout.rates.sample_dt / f64::from(layout.oversample());
    let own = if layout.rates.frame == 1 { 0.5 } else { 1.0 };
    Delays { frame, force, sound: force + filter, filter, spring: frame * (own + late) + tick }
}

impl Delays {
    /// The friction of its own \[N s/m\] with which a device stays passive on springs that sum to `k` \[N/m\].
    pub fn friction(&self, k: f64) -> f64 {
        k * self.spring
    }

    /// The largest sum of springs \[N/m\] on which a device of friction `b` \[N s/m\] stays passive.
    pub fn stiffest(&self, b: f64) -> f64 {
        b / self.spring
    }
}
