//! H5, H6, H8, H9: decides when forces may reach the hand.
//!
//! Off → ramp → on. The ramp begins once the gate is armed, the device is calibrated and fresh, the scene is where the
//! device is, and nothing has pushed for a while. A fault latches until the gate is armed again; data that return do
//! not end it. Excess speed brakes for a moment before forces go off.
//!
//! A force of a replaced scene fades out in the same time as one without fresh frames. Without fresh frames the force
//! is held, then fades, then is a fault: `WATCHDOG_IN` where no frames came, `IMPLAUSIBLE` where frames were rejected.
//! Losing the calibration while forces are on is `IMPLAUSIBLE` too, since positions are no longer metres.

use super::saturation::limit;
use super::wait::Wait;
use super::{GuardFrame, Order, Stage};
use crate::frame::{Cause, DOF, Mode, flag};
use crate::profile::Profile;

/// Gate for arming, fade-in and faults.
pub struct Gate {
    axes: usize,
    mode: Mode,
    cause: Cause,
    armed: bool,
    /// Engine frames for which nothing has pushed (off), or since the ramp or the brake began.
    since: u32,
    /// Frames left of a fade-out.
    fading: Option<u32>,
    clear: f64,
    clear_frames: u32,
    ramp_frames: u32,
    hold: u32,
    zero: u32,
    speed: f64,
    brake: f64,
    stop_frames: u32,
    most: f64,
    faults: u64,
    wait: Wait,
    described: bool,
}

/// Returns the whole frames in `t` seconds, at least 1.
pub(super) fn frames(t: f64, frame_dt: f64) -> u32 {
    (t / frame_dt).round().clamp(1.0, 1e9) as u32
}

impl Gate {
    /// Builds the gate from a profile, at `frame_dt` seconds a frame.
    pub fn new(profile: &Profile, frame_dt: f64) -> Gate {
        let l = &profile.guard;
        Gate {
            axes: profile.axes as usize,
            mode: Mode::Off,
            cause: Cause::Disarmed,
            armed: false,
            since: 0,
            fading: None,
            clear: l.clear * profile.force,
            clear_frames: frames(l.clear_time, frame_dt),
            ramp_frames: frames(l.ramp, frame_dt),
            hold: frames(profile.hold(), frame_dt),
            zero: frames(l.zero, frame_dt),
            speed: l.speed,
            brake: l.brake,
            stop_frames: frames(l.stop, frame_dt),
            most: profile.force.min(profile.continuous()),
            faults: 0,
            wait: Wait::Nothing,
            described: !(profile.is_unknown() && profile.force == 0.0),
        }
    }

    /// Fades out the force sent last; forces begin anew after it.
    pub fn fade_out(&mut self) {
        (self.mode, self.fading) = (Mode::Ramp, Some(self.zero));
    }

    /// Arms, disarms or trips.
    pub fn order(&mut self, order: Order) {
        // disarming and tripping end a force at once
        if order != Order::Arm {
            self.fading = None;
        }
        match order {
            Order::Arm => {
                // a brake first ends in its fault
                if !self.armed || self.mode == Mode::Fault {
                    (self.armed, self.mode, self.cause, self.since) = (true, Mode::Off, Cause::None, 0);
                }
            }
            Order::Disarm => {
                (self.armed, self.mode, self.cause, self.since) = (false, Mode::Off, Cause::Disarmed, 0);
            }
            Order::Trip(cause) => self.fault(cause),
        }
    }

    fn fault(&mut self, cause: Cause) {
        if self.armed && self.mode != Mode::Fault {
            (self.mode, self.cause, self.armed, self.since) = (Mode::Fault, cause, false, 0);
            self.faults += 1;
        }
    }

    /// Returns what kept forces from beginning in the last frame.
    pub fn wait(&self) -> Wait {
        self.wait
    }

    fn waits(&self, hand: &GuardFrame) -> Wait {
        if hand.age > self.hold {
            return Wait::Stale;
        }
        if !self.described {
            return Wait::Undescribed;
        }
        if !hand.calibrated {
            return Wait::NotReady;
        }
        if hand.arrived != u32::MAX {
            return Wait::OnTheWay;
        }
        let mut wait = Wait::Nothing;
        for at in (0..hand.n).step_by(self.axes) {
            let f = hand.length(at, self.axes);
            if f > 0.0 && f >= self.clear {
                let (most, count) = match wait {
                    Wait::Presses { dof, force, count, .. } if force >= f => ((dof, force), count),
                    Wait::Presses { count, .. } => ((at as u32, f), count),
                    _ => ((at as u32, f), 0),
                };
                wait = Wait::Presses { dof: most.0, force: most.1, limit: self.clear, count: count + 1 };
            }
        }
        if wait == Wait::Nothing {
            for (dof, v) in hand.v[..hand.n].iter().enumerate().filter(|(_, v)| v.abs() > self.speed) {
                wait = Wait::Fast { dof: dof as u32, speed: v.abs(), limit: self.speed };
            }
        }
        wait
    }

    /// Returns true if the gate was armed, and no fault ended that.
    pub fn is_armed(&self) -> bool {
        self.armed
    }

    /// Returns the number of faults that latched so far.
    pub fn faults(&self) -> u64 {
        self.faults
    }
}

impl Stage for Gate {
    fn name(&self) -> &'static str {
        "gate"
    }

    fn pass(&mut self, hand: &mut GuardFrame) {
        let fast = hand.v[..hand.n].iter().any(|v| v.abs() > self.speed);
        if fast && self.armed && matches!(self.mode, Mode::Ramp | Mode::On) {
            (self.mode, self.cause, self.since) = (Mode::Damp, Cause::Velocity, 0);
        }
        if hand.tripped != Cause::None {
            self.fault(hand.tripped);
        }
        if let Some(left) = self.fading.filter(|_| self.mode == Mode::Ramp) {
            hand.flags |= flag::WAIT_CLEAR;
            let part = f64::from(left.saturating_sub(1)) / f64::from(left.max(1));
            // the fade goes on while the slew limit still holds back a force
            let on = hand.sent[..hand.n].iter().any(|f| *f != 0.0);
            hand.force = hand.sent.map(|f| part * f);
            (self.mode, self.fading) = if on { (Mode::Ramp, Some(left.saturating_sub(1))) } else { (Mode::Off, None) };
            (self.since, hand.mode, hand.cause) = (0, self.mode, self.cause);
            return;
        }
        self.fading = None;
        if self.mode != Mode::Off && hand.age >= self.zero {
            // frames came recently but were rejected: not a silent device
            self.fault(if hand.silent <= self.hold { Cause::Implausible } else { Cause::WatchdogIn });
        }
        if self.mode != Mode::Off && !hand.calibrated {
            self.fault(Cause::Implausible);
        }
        let mut gain = 0.0;
        self.wait = Wait::Nothing;
        match self.mode {
            Mode::Off if self.armed => {
                hand.flags |= flag::WAIT_CLEAR;
                self.wait = self.waits(hand);
                self.since = if self.wait == Wait::Nothing { self.since + 1 } else { 0 };
                if self.since >= self.clear_frames {
                    (self.mode, self.since) = (Mode::Ramp, 0);
                }
            }
            Mode::Ramp => {
                self.since += 1;
                gain = f64::from(self.since) / f64::from(self.ramp_frames);
                if self.since >= self.ramp_frames {
                    self.mode = Mode::On;
                }
            }
            Mode::On => gain = 1.0,
            Mode::Damp => {
                self.since += 1;
                for k in 0..hand.n {
                    hand.force[k] = -self.brake * hand.v[k];
                }
                for at in (0..hand.n).step_by(self.axes) {
                    limit(&mut hand.force[at..(at + self.axes).min(hand.n)], self.most);
                }
                gain = 1.0;
                if self.since >= self.stop_frames {
                    self.fault(Cause::Velocity);
                    gain = 0.0;
                }
            }
            _ => {}
        }
        if hand.age > self.hold {
            hand.flags |= flag::STALE;
            let left =
                f64::from(self.zero.saturating_sub(hand.age)) / f64::from(self.zero.saturating_sub(self.hold).max(1));
            gain *= left.clamp(0.0, 1.0);
        }
        if gain == 0.0 {
            hand.force = [0.0; DOF];
        } else if gain != 1.0 {
            for f in &mut hand.force[..hand.n] {
                *f *= gain;
            }
        }
        (hand.mode, hand.cause) = (self.mode, self.cause);
    }
}
