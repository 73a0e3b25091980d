//! H10: which frames of a device can be true, and how fast the hand moves.
//!
//! Decides before the model sees anything: a frame of another layout, of a number that does not grow, with a position
//! that is marked invalid, is no number or could not have been reached by a hand since the last good frame is dropped and
//! counted; the last good position stays. Ten of them within a tenth of a second are a fault, and ten old ones in order a new beginning. A new
//! session of the device process starts afresh, with forces off: what was armed was another process.
//!
//! Speed is measured over frames of the *device*, at least three of them and so long that a step of its sensor is no
//! motion: an 8-bit fader at 500 Hz moves in jumps of 0.39 mm, which over a single frame of the engine would be more
//! than a metre a second. One wrong position within what H10 lets pass is then no velocity trip either. The clock of the
//! device is used where it agrees with ours, else ours.

use super::GuardFrame;
use crate::frame::{Cause, DOF, DeviceFrame, Mode, status};
use crate::profile::Profile;

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameVerdict {
    /// used
    Good,
    /// not a frame of this version and layout, or with fewer degrees of freedom than the profile has
    Foreign,
    /// its number did not grow
    Old,
    /// a position is marked as not valid
    Masked,
    /// a position is not finite
    Nonfinite,
    /// no hand moves so fast
    Jump,
}

/// The way in of one device.
pub struct InputValidator {
    n: usize,
    frame_dt: f64,
    session: u64,
    seq: u64,
    /// fastest motion that is believed \[m/s\], and what the sensor adds to it \[m\]
    reach: f64,
    grain: f64,
    /// length over which speed is measured \[s\]
    window: f64,
    /// engine frame before which the last frame of any kind came
    heard: u64,
    bad: u32,
    bad_frames: u64,
    /// engine frames of the last bad ones, a ring
    when: [u64; 64],
    count: u64,
    /// the last good frames, a ring, and how many there were in this session
    past: [Seen; PAST],
    seen: usize,
    /// number of the last frame that was too old, and how many came before it, one after the other
    stray: u64,
    strays: u32,
    /// where the hand was in the frame before \[m\]
    before: [f64; DOF],
    /// frames that were dropped
    pub dropped: u64,
}

/// A good frame.
#[derive(Clone, Copy)]
struct Seen {
    /// engine frame before which it came
    at: u64,
    /// clock of the device, and ours as it read it \[ns\]
    clock: u64,
    host: u64,
    x: [f64; DOF],
}

/// Good frames that are remembered.
const PAST: usize = 32;
/// Steps of the sensor in the window of a speed, at the speed of the trip: it errs by an eighth of that at most.
const STEPS: f64 = 8.0;
/// Longest times between two good frames in that window: the farthest jump that is believed goes at twice the speed of
/// the trip for one of them.
const SPIKE: f64 = 2.3;
/// What must be so, and not so, before forces may come.
const READY: u32 = status::CALIBRATED | status::POWERED | status::BRAKE;

impl InputValidator {
    /// As the profile says, at engine frames of `frame_dt` seconds.
    pub fn new(profile: &Profile, frame_dt: f64) -> InputValidator {
        let grain = profile.grain();
        InputValidator {
            n: profile.dof as usize,
            frame_dt,
            session: 0,
            seq: 0,
            reach: 2.0 * profile.guard.speed,
            grain,
            window: (3.0 / profile.rate)
                .max(SPIKE * (1.0 / profile.rate + frame_dt))
                .max(STEPS * grain / profile.guard.speed),
            heard: 0,
            bad: profile.guard.bad.clamp(1, 64),
            bad_frames: u64::from(super::gate::frames(profile.guard.bad_time, frame_dt)),
            when: [0; 64],
            count: 0,
            past: [Seen { at: 0, clock: 0, host: 0, x: [0.0; DOF] }; PAST],
            seen: 0,
            stray: 0,
            strays: 0,
            before: [0.0; DOF],
            dropped: 0,
        }
    }

    /// The last good frame but `back`.
    fn last(&self, back: usize) -> Option<&Seen> {
        (back < self.seen.min(PAST)).then(|| &self.past[(self.seen - 1 - back) % PAST])
    }

    /// Looks at a frame that came before engine frame `hand.frame`; a good one moves the hand.
    pub fn take(&mut self, f: &DeviceFrame, hand: &mut GuardFrame) -> FrameVerdict {
        let verdict = self.judge(f, hand);
        self.heard = hand.frame;
        if verdict == FrameVerdict::Good {
            if self.seen == 0 || f.session != self.session {
                if self.seen > 0 {
                    hand.trip(Cause::Disconnect);
                }
                (self.seen, hand.met) = (0, 0);
                self.before[..self.n].copy_from_slice(&f.pos[..self.n]);
                hand.v = [0.0; DOF];
            }
            (self.session, self.seq) = (f.session, f.seq);
            hand.x[..self.n].copy_from_slice(&f.pos[..self.n]);
            self.past[self.seen % PAST] = Seen { at: hand.frame, clock: f.t_device_ns, host: f.t_host_ns, x: hand.x };
            // it counts on for ever, but a ring of 32 forgets how often it went round
            self.seen = if self.seen + 1 == 2 * PAST { PAST } else { self.seen + 1 };
            hand.calibrated = f.status & READY == status::CALIBRATED | status::POWERED;
            hand.fresh = true;
            hand.ack = f.ack;
            device_says(f, hand);
        } else {
            match verdict {
                FrameVerdict::Old => self.reject(f.seq, hand),
                // where it is cannot be true; that somebody let go may be
                FrameVerdict::Masked | FrameVerdict::Nonfinite | FrameVerdict::Jump => device_says(f, hand),
                _ => {}
            }
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

    /// A number that was too large once is believed no longer than the frames after it go on as if it had never been:
    /// as many of them as make a fault begin anew, with forces off.
    fn reject(&mut self, seq: u64, hand: &mut GuardFrame) {
        self.strays = if seq == self.stray.wrapping_add(1) { self.strays + 1 } else { 0 };
        self.stray = seq;
        if self.strays >= self.bad {
            (self.seen, self.strays) = (0, 0);
            (hand.calibrated, hand.met) = (false, 0);
            hand.trip(Cause::Implausible);
        }
    }

    fn judge(&self, f: &DeviceFrame, hand: &GuardFrame) -> FrameVerdict {
        if !f.is_ours() || (f.n as usize) < self.n {
            return FrameVerdict::Foreign;
        }
        let last = self.last(0).filter(|_| f.session == self.session);
        if last.is_some() && f.seq <= self.seq {
            return FrameVerdict::Old;
        }
        if f.mask & self.needed() != self.needed() {
            return FrameVerdict::Masked;
        }
        if f.pos[..self.n].iter().any(|x| !x.is_finite()) {
            return FrameVerdict::Nonfinite;
        }
        if let Some(last) = last {
            // the longer of the two clocks: a frame that was late in one of them is no jump
            let ours = (hand.frame - last.at + 1) as f64 * self.frame_dt;
            let mut theirs = f.t_device_ns.saturating_sub(last.clock).min(1_000_000_000);
            if f.t_host_ns > 0 && last.host > 0 {
                // a clock in other units, or a wild one, is as long as the other one says
                theirs = theirs.min(f.t_host_ns.saturating_sub(last.host));
            }
            let theirs = theirs as f64 * 1e-9;
            let most = self.reach * ours.max(theirs) + self.grain;
            if f.pos[..self.n].iter().zip(&last.x).any(|(a, b)| (a - b).abs() > most) {
                return FrameVerdict::Jump;
            }
        }
        FrameVerdict::Good
    }

    /// The positions that must be valid, a bit each.
    fn needed(&self) -> u32 {
        if self.n >= DOF { u32::MAX } else { (1 << self.n) - 1 }
    }

    /// Once a frame, after all frames that came: motion, speed and age.
    pub fn update(&mut self, hand: &mut GuardFrame) {
        for k in 0..self.n {
            hand.moved[k] = hand.x[k] - self.before[k];
        }
        self.before = hand.x;
        let Some(new) = self.last(0) else {
            // nobody speaks, or nobody who can be believed
            hand.age = u32::MAX;
            return;
        };
        hand.age = u32::try_from(hand.frame - new.at).unwrap_or(u32::MAX);
        hand.silent = u32::try_from(hand.frame - self.heard).unwrap_or(u32::MAX);
        if !hand.fresh {
            return;
        }
        // a quarter of a frame less: three frames of a clock are three frames
        let (mut old, mut length) = (new, 0.0);
        for back in 1..PAST {
            // too short a past says more of the sensor than of the hand
            let Some(earlier) = self.last(back) else { return };
            (old, length) = (earlier, self.between(earlier, new));
            if length >= self.window - 0.25 * self.frame_dt {
                break;
            }
        }
        if length > 0.0 {
            for k in 0..self.n {
                hand.v[k] = (new.x[k] - old.x[k]) / length;
            }
        }
    }

    /// Seconds between two good frames.
    fn between(&self, old: &Seen, new: &Seen) -> f64 {
        let ours = ((new.at - old.at) as f64 * self.frame_dt).max(self.frame_dt);
        let theirs = new.clock.saturating_sub(old.clock) as f64 * 1e-9;
        // frames wait in queues, so ours may be short or long by some; a clock in other units is off by far more
        let slack = 3.0 * self.frame_dt;
        if theirs > 0.5 * (ours - slack) && theirs < 2.0 * (ours + slack) && theirs > 0.0 { theirs } else { ours }
    }

    /// Session and number of the last good frame.
    pub fn ack(&self) -> (u64, u64) {
        (self.session, self.seq)
    }
}

/// What the device reports of itself.
fn device_says(f: &DeviceFrame, hand: &mut GuardFrame) {
    if f.status & status::CONNECTED == 0 {
        hand.trip(Cause::Disconnect);
    }
    let gives = matches!(hand.mode, Mode::Ramp | Mode::On | Mode::Damp);
    if gives && f.status & (status::POWERED | status::BRAKE) != status::POWERED {
        hand.trip(Cause::Disconnect);
    }
    if f.status & status::DEADMAN != 0 {
        hand.trip(Cause::Deadman);
    }
    if f.status & status::THERMAL != 0 {
        hand.trip(Cause::Thermal);
    }
    match Cause::read(f.cause) {
        // what only an engine can find: it repeats what it was sent, and must not keep alive a fault that was ended
        Cause::None
        | Cause::Disarmed
        | Cause::WatchdogIn
        | Cause::Nonfinite
        | Cause::Implausible
        | Cause::ModelUnstable => {}
        // it missed forces that were not on, or repeats what it was sent: no reason against the next ones
        Cause::WatchdogOut | Cause::Disconnect | Cause::Velocity | Cause::Software
            if matches!(hand.mode, Mode::Off | Mode::Fault) => {}
        cause => hand.trip(cause),
    }
}

#[cfg(test)]
mod tests;
