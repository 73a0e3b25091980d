//! Mean force of a coupled key over each frame of a device that is slower than the engine.
//!
//! The position of such a device moves in one frame of the engine and rests in the others, so the damper of a coupling
//! gives all its force in the first of them. The device would use one of these forces, depending on the phase of the
//! two clocks, and a key in free air could push the hand. The mean over a whole frame of the device is the change of
//! momentum behind the coupling, whatever the phase is. It comes one frame of the device later, which
//! [`crate::coupling::StiffnessLimits`] takes into account.

use crate::frame::DOF;
use crate::profile::Profile;

/// Returns true for a device whose frames are longer than a frame of the engine, `frame_dt` seconds.
pub(crate) fn is_slower(profile: &Profile, frame_dt: f64) -> bool {
    profile.rate * frame_dt < 1.0 - 1e-9
}

/// Sum of the forces since the last frame of the device, and mean over the frame before it.
#[derive(Clone)]
pub(super) struct MeanForce {
    sum: [f64; DOF],
    frames: f64,
    mean: [f64; DOF],
}

impl MeanForce {
    pub(super) fn new() -> MeanForce {
        MeanForce { sum: [0.0; DOF], frames: 0.0, mean: [0.0; DOF] }
    }

    /// Replaces the forces of a frame \[N\] by the mean. `fresh` is true if a frame of the device came before it.
    pub(super) fn pass(&mut self, force: &mut [f64], fresh: bool) {
        if fresh && self.frames > 0.0 {
            for (mean, sum) in self.mean.iter_mut().zip(&mut self.sum) {
                *mean = core::mem::take(sum) / self.frames;
            }
            self.frames = 0.0;
        }
        self.frames += 1.0;
        for ((f, sum), mean) in force.iter_mut().zip(&mut self.sum).zip(&self.mean) {
            *sum += *f;
            *f = *mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_is_of_whole_frames() {
        let mut mean = MeanForce::new();
        let mut sent = Vec::new();
        for (k, f) in [3.0, 0.0, 0.0, 6.0, 0.0, 0.0, 0.0, 2.0, 2.0].into_iter().enumerate() {
            let mut force = [f];
            mean.pass(&mut force, [0, 3, 7].contains(&k));
            sent.push(force[0]);
        }
        assert_eq!(sent, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.5, 1.5]);
    }
}
