//! H12: the rate boundary gives no energy that the hand did not bring.
//!
//! Decides on a band-limited ledger and on a small viscosity, rather than on the exact ledger and a force that repays it
//! within a frame (the controller of Hannaford and Ryu 2002, which this stage was once). The device holds the force of
//! an earlier frame, so that over a stiff wall the boundary makes energy like a negative viscosity K T κ
//! (docs/numerics.md §5.2). The device's own friction takes it out again, and only what is left over counts here:
//!
//! ```text
//! leak += ((f_acting − f_mean)·v − CREDIT b v² − b_injected v²) T       f_injected = −b_injected v
//! ```
//!
//! Here v is the speed of the hand and f_acting − f_mean is the force that acted less the mean force of the model over
//! the same frame. Both are low-passed by the same filter, so noise and steps of the sensor, which are fast, hardly enter,
//! and where K T κ is less than the friction that is counted the leak stays at zero whatever the sensor does. Speeds that
//! one step or the noise of the profile would show are not motion (a dead zone).
//!
//! The viscosity grows with the leak up to `passivity_viscosity` of the device's own friction. That bound is what keeps
//! it from giving energy at any delay and frequency: of a viscosity b through a filter H and a delay τ no more than
//! −b Re{H e^(−jωτ)} ≤ b comes back as a negative one. The leak is capped and an old credit is forgotten, in the manner
//! of a reference energy that is followed rather than of a debt that is collected (Ryu, Preusche, Hannaford and Hirzinger
//! 2005), so that nothing is paid at once when a hand lets go. What cannot be held passively by such a viscosity is named
//! by `ca check --device`, and ended by the oscillation stage.
//!
//! The work of the injection itself is added up. Where it becomes positive, the injection stops for two seconds, for
//! twice as long the next time, and every frame of that time carries a flag.
//!
//! The ledger begins anew whenever forces are not fully on, and counts once they were for as long as a device may be late.

use super::gate::frames;
use super::saturation::limit;
use super::{GuardFrame, PAST, Stage, norm};
use crate::frame::{DOF, Mode, flag};
use crate::profile::Profile;

/// Part of the device's friction that counts as taking out energy: the other part is what a profile may be wrong by.
const CREDIT: f64 = 0.5;
/// Part of the largest leak at which the viscosity is the largest; also the largest credit.
const REFERENCE: f64 = 0.25;
/// Time constant in which a credit is forgotten \[s\].
const FORGET: f64 = 0.5;
/// Work of the injection on the hand at which it stops \[J\], what of the energy it took out counts against that \[J\], and
/// the time constant in which both are forgotten \[s\].
const WORK: f64 = 1e-5;
const TAKEN: f64 = 1e-4;
const WORK_TIME: f64 = 5.0;
/// For how long it stops, the first time and at most \[s\].
const STOP: [f64; 2] = [2.0, 64.0];

/// Observer and controller, per vector of force.
pub struct Passivity {
    axes: usize,
    /// largest force of a vector, and of the injection \[N\]
    most: f64,
    injection: f64,
    /// friction that is counted, and the largest viscosity that is injected \[N s/m\]
    friction: f64,
    viscosity: f64,
    /// share of the new value in each pole of the low-pass
    share: f64,
    /// speed below which nothing counts as motion \[m/s\]
    dead: f64,
    /// largest leak \[J\]
    cap: f64,
    stop: [u32; 2],
    /// frames for which forces have been fully on, up to the length of the ring
    on: usize,
    axis: [Axis; DOF],
    vector: [Vector; DOF],
    /// forces before the injection, and of the injection, a ring by the number of their frame \[N\]
    past: Box<[[[f64; DOF]; 2]; PAST]>,
}

/// Two equal poles of a low-pass, of speed and of the difference of forces.
#[derive(Clone, Copy, Default)]
struct Axis {
    speed: [f64; 2],
    force: [f64; 2],
}

#[derive(Clone, Copy)]
struct Vector {
    leak: f64,
    work: f64,
    /// frames for which the injection stays off, and for which it will be off the next time
    off: u32,
    next: u32,
}

fn low_pass(pole: &mut [f64; 2], share: f64, x: f64) -> f64 {
    pole[0] += share * (x - pole[0]);
    pole[1] += share * (pole[0] - pole[1]);
    pole[1]
}

impl Passivity {
    /// As the profile says, at frames of `frame_dt` seconds; `None` where it is not wanted, or where the device has no friction
    /// of its own, beside which no viscosity could be safe.
    pub fn new(profile: &Profile, frame_dt: f64) -> Option<Passivity> {
        let l = &profile.guard;
        let viscosity = l.passivity_viscosity * profile.body.friction;
        // two poles are 3 dB down together at 0.64 of the frequency of each
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
        // the mode is still that of the frame before: the force that did the work
        self.on = if hand.mode == Mode::On { (self.on + 1).min(PAST) } else { 0 };
        // whatever force a device says it held was fully on by then
        let on = self.on == PAST;
        for at in (0..hand.n).step_by(self.axes) {
            let end = (at + self.axes).min(hand.n);
            let s = &mut self.vector[at];
            if !on {
                // also the filters: which force a device held while it appeared is a matter of chance
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
            // the part of the speed beyond the dead zone
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
