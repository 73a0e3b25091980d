//! H12: removes energy that the rate boundary makes and the hand did not supply.
//!
//! This stage uses a band-limited ledger and a small viscosity. The exact ledger with a force that repays it within a
//! frame (Hannaford and Ryu 2002) would make energy under sensor noise. The device holds the force of an earlier frame,
//! so that over a stiff wall the boundary makes energy like a negative viscosity K T κ (docs/numerics.md §5.2). The
//! device's own friction dissipates it, and only the rest counts here:
//!
//! ```text
//! leak += ((f_acting − f_mean)·v − CREDIT b v² − b_injected v²) T       f_injected = −b_injected v
//! ```
//!
//! K is the stiffness at the key, T the length of a frame, κ the mean delay in frames, b the friction of the
//! device, and v the speed of the hand. f_acting is the force before injection in the frame that the device held.
//! f_acting − f_mean is that force less the mean force of the model over the same frame. The same low-pass filters
//! both, which removes most noise and steps of the sensor. If K T κ is below the counted friction, the leak
//! stays at zero, whatever the sensor measures. Speeds that a single step or the noise of the profile would show do not
//! count as motion (a dead zone).
//!
//! The viscosity grows with the leak up to `passivity_viscosity` of the device's own friction. This bound keeps it
//! passive at any delay and frequency: through a filter H and a delay τ, a viscosity b can act as a negative one of at
//! most −b Re{H e^(−jωτ)} ≤ b. The leak is capped and an old credit decays, as with a reference energy that is followed
//! (Ryu, Preusche, Hannaford and Hirzinger 2005), so that no burst of force repays it when a hand lets go.
//! `ca check --device` names keys that such a viscosity cannot hold passively, and the oscillation stage ends their
//! shaking.
//!
//! The stage sums the work of the injection. If that becomes positive, the injection stops for two seconds, and for
//! twice as long the next time; every frame of that time carries a flag.
//!
//! The ledger restarts whenever forces are not fully on, and counts once they have been on for the longest delay of a
//! device.

use super::gate::frames;
use super::saturation::limit;
use super::{GuardFrame, PAST, Stage, norm};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Part of the device's friction that counts as dissipation; the rest allows for an inexact profile.
const CREDIT: f64 = 0.5;
/// Part of the largest leak at which the viscosity is largest; also the largest credit.
const REFERENCE: f64 = 0.25;
/// Time constant of the decay of a credit \[s\].
const FORGET: f64 = 0.5;
/// Work of the injection on the hand at which it stops \[J\], the largest dissipated energy that counts against it
/// \[J\], and the time constant with which both decay \[s\].
const WORK: f64 = 1e-5;
const TAKEN: f64 = 1e-4;
const WORK_TIME: f64 = 5.0;
/// Duration of a stop, the first time and at most \[s\].
const STOP: [f64; 2] = [2.0, 64.0];

/// Passivity observer and controller per force vector.
pub struct Passivity {
    axes: usize,
    /// Largest force of a vector, and of the injection \[N\].
    most: f64,
    injection: f64,
    /// Friction that counts, and the largest injected viscosity \[N s/m\].
    friction: f64,
    viscosity: f64,
    /// Weight of the new value in each pole of the low-pass.
    share: f64,
    /// Speed below which nothing counts as motion \[m/s\].
    dead: f64,
    cap: f64,
    stop: [u32; 2],
    /// Frames for which forces have been fully on, at most the length of the ring.
    on: usize,
    axis: [Axis; DOF],
    vector: [Vector; DOF],
    /// Forces before the injection, and injected forces, a ring by the number of their frame \[N\].
    past: Box<[[[f64; DOF]; 2]; PAST]>,
}

/// State of a low-pass with two equal poles, for speed and for the difference of forces.
#[derive(Clone, Copy, Default)]
struct Axis {
    speed: [f64; 2],
    force: [f64; 2],
}

#[derive(Clone, Copy)]
struct Vector {
    leak: f64,
    work: f64,
    /// Frames for which the injection stays off now, and for which it will the next time.
    off: u32,
    next: u32,
}

fn low_pass(pole: &mut [f64; 2], share: f64, x: f64) -> f64 {
    pole[0] += share * (x - pole[0]);
    pole[1] += share * (pole[0] - pole[1]);
    pole[1]
}

impl Passivity {
    /// Builds the stage from a profile, at `frame_dt` seconds a frame.
    ///
    /// Returns `None` if the profile turns it off, or for a device without friction, where no viscosity is safe.
    pub fn new(profile: &Profile, frame_dt: f64) -> Option<Passivity> {
        let l = &profile.guard;
        let viscosity = l.passivity_viscosity * profile.body.friction;
        // two equal poles together are 3 dB down at 0.64 of the frequency of each
        let w = core::f64::consts::TAU * l.passivity_band / 0.64;
        let stop = STOP.map(|t| frames(t, frame_dt));
        (l.passivity && profile.force > 0.0 && viscosity > 0.0).then(|| Passivity {
            axes: profile.axes as usize,
            most: profile.force,
            injection: l.passivity_force * profile.force,
            friction: CREDIT * profile.body.friction,
            viscosity,
            share: w * frame_dt / (1.0 + w * frame_dt),
            dead: profile.grain() * core::f64::consts::TAU * l.passivity_band,
            cap: l.passivity_leak,
            stop,
            on: 0,
            axis: [Axis::default(); DOF],
            vector: [Vector { leak: 0.0, work: 0.0, off: 0, next: stop[0] }; DOF],
            past: Box::new([[[0.0; DOF]; 2]; PAST]),
        })
    }
}

impl Stage for Passivity {
    fn name(&self) -> &'static str {
        "passivity"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        let now = (hand.frame + 1) as usize % PAST;
        let [asked, injected] = self.past[(hand.frame + 1 - hand.ago) as usize % PAST];
        self.past[now] = [hand.force, [0.0; DOF]];
        // the mode of the frame before, whose force did the work
        self.on = if hand.mode == Mode::On { (self.on + 1).min(PAST) } else { 0 };
        // any force that the device may report as held was fully on
        let on = self.on == PAST;
        for at in (0..hand.n).step_by(self.axes) {
            let end = (at + self.axes).min(hand.n);
            let s = &mut self.vector[at];
            if !on {
                // resets the filters too: the force held as a device appeared is arbitrary
                self.axis[at..end].fill(Axis::default());
                *s = Vector { leak: 0.0, work: 0.0, off: 0, next: self.stop[0] };
                continue;
            }
            let (mut speed, mut made, mut work) = ([0.0; 3], 0.0, 0.0);
            for (k, v) in (at..end).zip(&mut speed) {
                let axis = &mut self.axis[k];
                *v = low_pass(&mut axis.speed, self.share, hand.moved[k] / hand.frame_dt);
                made += low_pass(&mut axis.force, self.share, asked[k] - hand.mean[k]) * *v;
                work += injected[k] * hand.moved[k];
            }
            // fraction of the speed beyond the dead zone
            let size = norm(&speed[..end - at]);
            let part = if size > self.dead { 1.0 - self.dead / size } else { 0.0 };
            let paid: f64 = (at..end).zip(speed).map(|(k, v)| injected[k] * v).sum();
            s.leak += part * (made - self.friction * size * size + paid) * hand.frame_dt;
            if s.leak < 0.0 {
                s.leak *= 1.0 - hand.frame_dt / FORGET;
            }
            s.leak = s.leak.clamp(-REFERENCE * self.cap, self.cap);
            s.work = (s.work * (1.0 - hand.frame_dt / WORK_TIME) + work).max(-TAKEN);
            if s.work > WORK && s.off == 0 {
                (s.off, s.next, s.work) = (s.next, (2 * s.next).min(self.stop[1]), 0.0);
            }
            if s.off > 0 {
                s.off -= 1;
                hand.flags |= flag::PASSIVITY_OFF;
                continue;
            }
            let viscosity = self.viscosity * (s.leak / (REFERENCE * self.cap)).clamp(0.0, 1.0);
            if viscosity * part == 0.0 {
                continue;
            }
            let b = (viscosity * part).min(self.injection / size);
            for (k, v) in (at..end).zip(speed) {
                self.past[now][1][k] = -b * v;
                hand.force[k] -= b * v;
            }
            limit(&mut hand.force[at..end], self.most);
            hand.inject = hand.inject.max(b);
            hand.flags |= flag::PASSIVITY;
        }
        hand.injected = self.past[now][1];
    }
}
