//! H10: which frames of a device can be true.
//!
//! Decides before the model sees anything: a frame of another layout, of a number that does not grow, with a position
//! that is no number or that no hand could have reached since the last good frame is dropped and counted; the last good
//! position stays. Ten of them within a tenth of a second are a fault. A new session of the device process starts
//! afresh, with forces off: what was armed was another process.

use super::Hand;
use crate::frame::{Cause, DOF, DeviceFrame, status};
use crate::profile::Profile;

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// used
    Good,
    /// not a frame of this version
    Foreign,
    /// its number did not grow
    Old,
    /// a position is no number
    Nonfinite,
    /// no hand moves so fast
    Jump,
}

/// The way in of one device.
pub struct Inlet {
    n: usize,
    te: f64,
    session: u64,
    seq: u64,
    /// frame of the engine in which the last good frame came
    at: Option<u64>,
    t_device: u64,
    reach: f64,
    bad: u32,
    bad_frames: u64,
    /// engine frames of the last bad ones, a ring
    when: [u64; 64],
    count: u64,
    /// positions of the last good frames, for the speed
    past: [[f64; DOF]; PAST],
    turn: usize,
    /// frames that were dropped
    pub dropped: u64,
}

/// Frames over which speed is measured: 1 ms at 3 kHz.
const PAST: usize = 3;

impl Inlet {
    /// As the profile says, at engine frames of `te` seconds.
    pub fn new(profile: &Profile, te: f64) -> Inlet {
        Inlet {
            n: profile.dof as usize,
            te,
            session: 0,
            seq: 0,
            at: None,
            t_device: 0,
            reach: 2.0 * profile.guard.speed,
            bad: profile.guard.bad.clamp(1, 64),
            bad_frames: u64::from(super::gate::frames(profile.guard.bad_time, te)),
            when: [0; 64],
            count: 0,
            past: [[0.0; DOF]; PAST],
            turn: 0,
            dropped: 0,
        }
    }

    /// Looks at a frame that came before engine frame `hand.frame`; a good one moves the hand.
    pub fn take(&mut self, f: &DeviceFrame, hand: &mut Hand) -> Verdict {
        let verdict = self.judge(f, hand);
        if verdict == Verdict::Good {
            let restarted = f.session != self.session;
            if restarted && self.session != 0 {
                hand.trip(Cause::Disconnect);
            }
            (self.session, self.seq, self.t_device, self.at) = (f.session, f.seq, f.t_device_ns, Some(hand.frame));
            hand.x[..self.n].copy_from_slice(&f.pos[..self.n]);
            hand.calibrated = f.status & status::CALIBRATED != 0;
            hand.fresh = true;
            if restarted {
                self.past = [hand.x; PAST];
                hand.moved = [0.0; DOF];
            }
            device_says(f, hand);
        } else {
            self.dropped += 1;
            self.when[(self.count % 64) as usize] = hand.frame;
            self.count += 1;
            if self.count >= u64::from(self.bad) {
                let first = self.when[((self.count - u64::from(self.bad)) % 64) as usize];
                if hand.frame - first <= self.bad_frames {
                    hand.trip(Cause::Implausible);
                }
            }
        }
        verdict
    }

    fn judge(&self, f: &DeviceFrame, hand: &Hand) -> Verdict {
        if !f.is_ours() || (f.n as usize) < self.n {
            return Verdict::Foreign;
        }
        let same = f.session == self.session;
        if same && f.seq <= self.seq {
            return Verdict::Old;
        }
        if f.pos[..self.n].iter().any(|x| !x.is_finite()) {
            return Verdict::Nonfinite;
        }
        if let (true, Some(at)) = (same, self.at) {
            // the longer of the two clocks: a frame that was late in one of them is no jump
            let ours = (hand.frame - at + 1) as f64 * self.te;
            let theirs = f.t_device_ns.saturating_sub(self.t_device).min(1_000_000_000) as f64 * 1e-9;
            let most = self.reach * ours.max(theirs);
            if f.pos[..self.n].iter().zip(&hand.x).any(|(a, b)| (a - b).abs() > most) {
                return Verdict::Jump;
            }
        }
        Verdict::Good
    }

    /// Once a frame, after all frames that came: speed, motion and age.
    pub fn settle(&mut self, hand: &mut Hand, before: &[f64; DOF]) {
        let old = self.past[self.turn];
        self.past[self.turn] = hand.x;
        self.turn = (self.turn + 1) % PAST;
        for k in 0..self.n {
            hand.moved[k] = hand.x[k] - before[k];
            hand.v[k] = (hand.x[k] - old[k]) / (PAST as f64 * self.te);
        }
        hand.age = self.at.map_or(u32::MAX, |at| u32::try_from(hand.frame - at).unwrap_or(u32::MAX));
    }

    /// Session and number of the last good frame.
    pub fn ack(&self) -> (u64, u64) {
        (self.session, self.seq)
    }
}

/// What the device reports of itself.
fn device_says(f: &DeviceFrame, hand: &mut Hand) {
    if f.status & status::DEADMAN != 0 {
        hand.trip(Cause::Deadman);
    }
    if f.status & status::THERMAL != 0 {
        hand.trip(Cause::Thermal);
    }
    if f.cause != 0 {
        hand.trip(Cause::read(f.cause));
    }
}
