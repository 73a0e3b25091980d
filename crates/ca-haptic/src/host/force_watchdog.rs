//! Selects the force frames that may reach a motor (H7, on the side of the device).
//!
//! It depends on frames and time only, without transport, so that it can be translated to other languages line by line.
//! A force is used if its frame is younger than its time to live, has the layout of this build, is for this device, and
//! has neither mode off nor mode fault. In addition, this device must have received a frame with mode off or fault from
//! the same session, which is one start of an engine. Each engine begins with such frames. If the first frame of a
//! session has a force, the engine began before this device listened. Otherwise the force is zero.

use crate::frame::{Cause, DOF, ForceFrame, Mode};

/// Longest lifetime of a force, whatever its frame says \[ns\].
pub const LONGEST_NS: u64 = 100_000_000;

/// State of the connection to the engine, for one device.
#[derive(Clone, Debug)]
pub struct ForceWatchdog {
    device: [u8; 16],
    last: Option<ForceFrame>,
    /// True once a frame with the session of `last` had mode off or fault.
    rested: bool,
    /// Number of frames for another device or with another layout.
    pub foreign: u64,
    /// Number of frames that are not newer than the last.
    pub old: u64,
    /// Number of changes of the engine's session.
    pub restarts: u64,
}

impl ForceWatchdog {
    /// Starts without a frame, for the device with this uid.
    pub fn new(device: [u8; 16]) -> ForceWatchdog {
        ForceWatchdog { device, last: None, rested: false, foreign: 0, old: 0, restarts: 0 }
    }

    /// Checks a frame and stores the newest. Returns true if this one is the newest.
    pub fn take(&mut self, f: &ForceFrame) -> bool {
        if !f.has_this_layout() || f.device != self.device {
            self.foreign += 1;
            return false;
        }
        if let Some(last) = &self.last {
            if f.session == last.session {
                if f.seq <= last.seq {
                    self.old += 1;
                    return false;
                }
            } else {
                self.restarts += 1;
                self.rested = false;
            }
        }
        self.rested |= matches!(Mode::read(f.mode), Mode::Off | Mode::Fault);
        self.last = Some(*f);
        true
    }

    /// Returns the newest frame.
    pub fn last(&self) -> Option<&ForceFrame> {
        self.last.as_ref()
    }

    /// Returns the forces for the motors \[N\] at time `now` \[ns\] of `CLOCK_MONOTONIC`.
    pub fn force(&self, now: u64) -> [f64; DOF] {
        let mut force = [0.0; DOF];
        if let (Cause::None, Some(f)) = (self.cause(now), &self.last) {
            for (to, from) in force.iter_mut().zip(&f.force[..f.n as usize]) {
                *to = f64::from(*from);
            }
        }
        force
    }

    /// Returns why the force at time `now` \[ns\] is zero, as far as the device knows; [`Cause::None`] if it is used.
    pub fn cause(&self, now: u64) -> Cause {
        let Some(f) = &self.last else { return Cause::Disconnect };
        let life = (u64::from(f.ttl_us) * 1000).min(LONGEST_NS);
        // a time in the future is from another clock
        if now == 0 || now.checked_sub(f.t_host_ns).is_none_or(|age| age > life) {
            return Cause::WatchdogOut;
        }
        match Mode::read(f.mode) {
            Mode::Off | Mode::Fault => match Cause::read(f.cause) {
                Cause::None => Cause::Disarmed,
                cause => cause,
            },
            _ if !self.rested => Cause::Disconnect,
            _ if f.force.iter().any(|x| !x.is_finite()) => Cause::Nonfinite,
            _ => Cause::None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn frame(session: u64, seq: u64, mode: Mode, at: u64) -> ForceFrame {
        let mut f = ForceFrame::new("key", 2);
        (f.session, f.seq, f.mode, f.t_host_ns, f.ttl_us) = (session, seq, mode as u32, at, 5000);
        (f.force[0], f.force[1], f.force[2]) = (1.5, -2.0, 9.0);
        f
    }

    fn watch() -> ForceWatchdog {
        let mut w = ForceWatchdog::new(crate::frame::uid("key"));
        assert!(w.take(&frame(7, 1, Mode::Off, MS)));
        w
    }

    #[test]
    fn a_force_lives_as_long_as_its_frame_says() {
        let mut w = watch();
        assert_eq!(w.cause(MS), Cause::Disarmed);
        assert!(w.take(&frame(7, 2, Mode::On, 10 * MS)));
        let mut want = [0.0; DOF];
        (want[0], want[1]) = (1.5, -2.0);
        assert_eq!(w.force(10 * MS), want, "only the DOF in use");
        assert_eq!(w.force(15 * MS), want);
        assert_eq!((w.force(15 * MS + 1), w.cause(15 * MS + 1)), ([0.0; DOF], Cause::WatchdogOut));
        // times of another clock
        assert_eq!((w.force(10 * MS - 1), w.force(0)), ([0.0; DOF], [0.0; DOF]));
        // `LONGEST_NS` limits `ttl_us`
        let mut f = frame(7, 3, Mode::On, 10 * MS);
        f.ttl_us = u32::MAX;
        assert!(w.take(&f));
        assert_eq!(w.cause(10 * MS + LONGEST_NS), Cause::None);
        assert_eq!(w.cause(10 * MS + LONGEST_NS + 1), Cause::WatchdogOut);
    }

    #[test]
    fn no_force_from_what_is_off_at_fault_or_no_number() {
        for (mode, gives) in [(0, false), (1, true), (2, true), (3, true), (4, false), (77, false)] {
            let mut w = watch();
            let mut f = frame(7, 2, Mode::On, MS);
            f.mode = mode;
            assert!(w.take(&f));
            assert_eq!(w.force(MS)[0] != 0.0, gives, "mode {mode}");
        }
        let mut w = watch();
        let mut f = frame(7, 2, Mode::On, MS);
        f.force[1] = f32::NAN;
        assert!(w.take(&f));
        assert_eq!((w.force(MS), w.cause(MS)), ([0.0; DOF], Cause::Nonfinite));
    }

    #[test]
    fn an_engine_that_was_not_seen_at_rest_gives_nothing() {
        let mut w = ForceWatchdog::new(crate::frame::uid("key"));
        assert_eq!(w.cause(MS), Cause::Disconnect, "nobody there");
        assert!(w.take(&frame(7, 5, Mode::On, MS)));
        assert_eq!((w.force(MS), w.cause(MS)), ([0.0; DOF], Cause::Disconnect));
        assert!(w.take(&frame(7, 6, Mode::Off, MS)) && w.take(&frame(7, 7, Mode::Ramp, MS)));
        assert_eq!(w.force(MS)[0], 1.5);
        // another engine takes over
        assert!(w.take(&frame(8, 1, Mode::On, MS)));
        assert_eq!((w.force(MS), w.restarts), ([0.0; DOF], 1));
        assert!(w.take(&frame(8, 2, Mode::Off, MS)) && w.take(&frame(8, 3, Mode::On, MS)));
        assert_eq!(w.force(MS)[0], 1.5);
    }

    #[test]
    fn frames_of_others_and_of_the_past_change_nothing() {
        let mut w = watch();
        assert!(w.take(&frame(7, 9, Mode::On, MS)));
        let before = w.force(MS);
        for change in [
            |f: &mut ForceFrame| f.magic = 1,
            |f: &mut ForceFrame| f.n = 0,
            |f: &mut ForceFrame| f.version += 1,
            |f: &mut ForceFrame| f.layout ^= 1,
            |f: &mut ForceFrame| f.n = 33,
            |f: &mut ForceFrame| f.device = crate::frame::uid("other"),
            |f: &mut ForceFrame| f.seq = 9,
            |f: &mut ForceFrame| f.seq = 3,
        ] {
            let mut f = frame(7, 10, Mode::On, MS);
            f.force = [5.0; DOF];
            change(&mut f);
            assert!(!w.take(&f));
            assert_eq!(w.force(MS), before);
        }
        assert_eq!((w.foreign, w.old), (6, 2));
        // without further frames the force ends with a cause
        assert_eq!(w.cause(6 * MS + 1), Cause::WatchdogOut);
    }
}
