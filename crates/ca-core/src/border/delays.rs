//! Response delays of a scene, and the demands that they make on a device.
//!
//! The delays follow from the scene alone; the time to compute a frame, sound buffers and the host loop add to them. A
//! frame is computed when its last position is known, so the response is one frame late (0.33 ms for the rattle). A
//! spring on a key acts with the delay κ·T of its mean force, which limits its stiffness (docs/numerics.md §5.2).

use crate::numeric::Real;
use crate::op::layout::Layout;

/// Delays of a scene, all in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delays {
    /// duration of a gesture frame, T
    pub frame: f64,
    /// delay from the position of the device to the force that responds to it
    pub force: f64,
    /// delay from the position of the device to the sound
    pub sound: f64,
    /// part of `sound` due to the low-pass of the outputs
    pub filter: f64,
    /// mean delay of a spring on a key, κ·T: half a frame of hold, half a frame for a mean of two positions, and
    /// `latency`
    pub spring: f64,
}

/// Returns the delays of a scene.
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
    /// Returns the friction \[N s/m\] that a device needs to stay passive on springs that sum to `k` \[N/m\].
    pub fn friction(&self, k: f64) -> f64 {
        k * self.spring
    }

    /// Returns the largest sum of springs \[N/m\] on which a device with friction `b` \[N s/m\] stays passive.
    pub fn stiffest(&self, b: f64) -> f64 {
        b / self.spring
    }
}
