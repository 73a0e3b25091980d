//! H10: rejects implausible device frames and measures the speed of the hand, before the model sees either.
//!
//! A frame is dropped and counted if its layout is foreign, its number does not grow, a position is marked invalid or
//! is not finite, or no hand could have reached the position since the last good frame. The last good position then
//! stays. Ten dropped frames within a tenth of a second are a fault; ten old ones in sequence start the numbering anew.
//! A new session of the device process starts with forces off, because another process was armed.
//!
//! Speed is measured over at least three frames of the *device*, and for so long that one step of its sensor does not
//! count as motion. An 8-bit fader at 500 Hz moves in jumps of 0.39 mm, which is more than a metre a second over a
//! single engine frame. A single wrong position that H10 accepts then does not trip the velocity limit either. The
//! clock of the device is used where it agrees with the host clock, and the host clock otherwise.

use super::GuardFrame;
use crate::frame::{Cause, DOF, DeviceFrame, Mode, status};
use crate::profile::Profile;

/// Result of checking a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameVerdict {
    /// The frame is used.
    Good,
    /// The version or layout is foreign, or the frame has fewer degrees of freedom than the profile.
    Foreign,
    /// The number did not grow.
    Old,
    /// A position is marked as not valid.
    Masked,
    /// A position is not finite.
    Nonfinite,
    /// A position is too far from the last good one.
    Jump,
}

/// Check of the frames of one device.
pub struct InputValidator {
    n: usize,
    frame_dt: f64,
    session: u64,
    seq: u64,
    /// Fastest motion accepted \[m/s\], and the resolution of the sensor, which is added to it \[m\].
    reach: f64,
    grain: f64,
    /// Time over which speed is measured \[s\].
    window: f64,
    /// Engine frame before which the last frame of any kind came.
    heard: u64,
    bad: u32,
    bad_frames: u64,
    when: [u64; 64],
    count: u64,
    /// The last good frames, a ring, and their number in this session.
    past: [Seen; PAST],
    seen: usize,
    /// Number of the last frame that was too old, and how many came before it in sequence.
    stray: u64,
    strays: u32,
    /// Position in the frame before \[m\].
    before: [f64; DOF],
    /// Number of dropped frames.
    pub dropped: u64,
}

#[derive(Clone, Copy)]
struct Seen {
    /// Engine frame before which it came.
    at: u64,
    /// Clock of the device, and the host clock as the device read it \[ns\].
    clock: u64,
    host: u64,
    x: [f64; DOF],
}

const PAST: usize = 32;
/// The window of a speed has this many sensor steps at the trip speed, so a step is at most an eighth of it.
const STEPS: f64 = 8.0;
/// Shortest window, as a multiple of the longest accepted gap between good frames: the mean over it of a jump at twice
/// the trip speed is below the trip speed.
const SPIKE: f64 = 2.3;
/// Status bits that matter before forces may begin: the first two set, `BRAKE` not.
const READY: u32 = status::CALIBRATED | status::POWERED | status::BRAKE;

impl InputValidator {
    /// Builds the check from a profile, at engine frames of `frame_dt` seconds.
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

    fn last(&self, back: usize) -> Option<&Seen> {
        (back < self.seen.min(PAST)).then(|| &self.past[(self.seen - 1 - back) % PAST])
    }

    /// Checks a frame that came before engine frame `hand.frame`; a good one moves the hand.
    pub fn take(&mut self, f: &DeviceFrame, hand: &mut GuardFrame) -> FrameVerdict {
        let verdict = self.judge(f, hand);
        self.heard = hand.frame;
        if verdict == FrameVerdict::Good {
            if self.seen == 0 || f.session != self.session {
                if self.seen > 0 {
                    hand.trip(Cause::Disconnect);
                }
                (self.seen, hand.arrived) = (0, 0);
                self.before[..self.n].copy_from_slice(&f.pos[..self.n]);
                hand.v = [0.0; DOF];
            }
            (self.session, self.seq) = (f.session, f.seq);
            hand.x[..self.n].copy_from_slice(&f.pos[..self.n]);
            self.past[self.seen % PAST] = Seen { at: hand.frame, clock: f.t_device_ns, host: f.t_host_ns, x: hand.x };
            // wraps from `2 * PAST` to `PAST`: the place in the ring is the same, and the counter cannot overflow
            self.seen = if self.seen + 1 == 2 * PAST { PAST } else { self.seen + 1 };
            hand.calibrated = f.status & READY == status::CALIBRATED | status::POWERED;
            hand.is_new = true;
            hand.ack = f.ack;
            device_says(f, hand);
        } else {
            match verdict {
                FrameVerdict::Old => self.reject(f.seq, hand),
                // the position is wrong, but the reported status may be right
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

    /// Handles a number that is too small. One wild large number could block all later frames: after as many frames in
    /// sequence as make a fault, numbering starts anew with forces off.
    fn reject(&mut self, seq: u64, hand: &mut GuardFrame) {
        self.strays = if seq == self.stray.wrapping_add(1) { self.strays + 1 } else { 0 };
        self.stray = seq;
        if self.strays >= self.bad {
            (self.seen, self.strays) = (0, 0);
            (hand.calibrated, hand.arrived) = (false, 0);
            hand.trip(Cause::Implausible);
        }
    }

    fn judge(&self, f: &DeviceFrame, hand: &GuardFrame) -> FrameVerdict {
        if !f.has_this_layout() || (f.n as usize) < self.n {
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
            // takes the longer of the two clocks: a frame that was late by one of them is not a jump
            let ours = (hand.frame - last.at + 1) as f64 * self.frame_dt;
            let mut theirs = f.t_device_ns.saturating_sub(last.clock).min(1_000_000_000);
            if f.t_host_ns > 0 && last.host > 0 {
                // limits a device clock in other units, or a wild one, by the host clock
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

    fn needed(&self) -> u32 {
        if self.n >= DOF { u32::MAX } else { (1 << self.n) - 1 }
    }

    /// Updates motion, speed and age; called once a frame after all frames that came.
    pub fn update(&mut self, hand: &mut GuardFrame) {
        for k in 0..self.n {
            hand.moved[k] = hand.x[k] - self.before[k];
        }
        self.before = hand.x;
        let Some(new) = self.last(0) else {
            // no good frame in this session yet
            hand.age = u32::MAX;
            return;
        };
        hand.age = u32::try_from(hand.frame - new.at).unwrap_or(u32::MAX);
        hand.silent = u32::try_from(hand.frame - self.heard).unwrap_or(u32::MAX);
        if !hand.is_new {
            return;
        }
        // a quarter of a frame of tolerance, for the jitter of the clocks
        let (mut old, mut length) = (new, 0.0);
        for back in 1..PAST {
            // over a shorter time the sensor would dominate the speed
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

    /// Returns the seconds between two good frames.
    fn between(&self, old: &Seen, new: &Seen) -> f64 {
        let ours = ((new.at - old.at) as f64 * self.frame_dt).max(self.frame_dt);
        let theirs = new.clock.saturating_sub(old.clock) as f64 * 1e-9;
        // frames wait in queues, so host time may be off by a few; a device clock in other units is off by far more
        let slack = 3.0 * self.frame_dt;
        if theirs > 0.5 * (ours - slack) && theirs < 2.0 * (ours + slack) && theirs > 0.0 { theirs } else { ours }
    }

    /// Returns session and number of the last good frame.
    pub fn ack(&self) -> (u64, u64) {
        (self.session, self.seq)
    }
}

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
        // only an engine finds these: the device repeats a cause sent to it, and must not revive a fault that was ended
        Cause::None
        | Cause::Disarmed
        | Cause::WatchdogIn
        | Cause::Nonfinite
        | Cause::Implausible
        | Cause::ModelUnstable => {}
        // forces were off, or the device repeats a cause sent to it: not a reason against the next forces
        Cause::WatchdogOut | Cause::Disconnect | Cause::Velocity | Cause::Software
            if matches!(hand.mode, Mode::Off | Mode::Fault) => {}
        cause => hand.trip(cause),
    }
}

#[cfg(test)]
mod tests;
