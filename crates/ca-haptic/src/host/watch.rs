//! H7, at the device: which force frames may reach a motor.
//!
//! Decides without any transport, as a pure function of frames and of the clock, so that every language can follow it
//! line by line. A force is given while its frame is younger than its time to live, of our layout, for this device, of a
//! session of the engine that was seen at rest, and neither off nor a fault. An engine that starts again is at rest
//! first, so a session that begins with a force is no beginning of ours. Everything else is zero.

use crate::frame::{Cause, DOF, ForceFrame, Mode};

/// Longest life of a force whatever its frame says \[ns\].
pub const LONGEST_NS: u64 = 100_000_000;

/// What a device knows of its engine.
#[derive(Clone, Debug)]
pub struct Watch {
    device: [u8; 16],
    last: Option<ForceFrame>,
    /// the session of `last` was seen at rest
    rested: bool,
    /// frames that were not for us, or not of this layout
    pub foreign: u64,
    /// frames older than one that was already there
    pub old: u64,
    /// how often the engine was another than before
    pub restarts: u64,
}

impl Watch {
    /// Of the device with this uid.
    pub fn new(device: [u8; 16]) -> Watch {
        Watch { device, last: None, rested: false, foreign: 0, old: 0, restarts: 0 }
    }

    /// Looks at a frame. True if it is the newest.
    pub fn take(&mut self, f: &ForceFrame) -> bool {
        if !f.is_ours() || f.device != self.device {
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

    /// The newest frame.
    pub fn last(&self) -> Option<&ForceFrame> {
        self.last.as_ref()
    }

    /// Forces to give at time `now` \[ns\], `CLOCK_MONOTONIC`.
    pub fn force(&self, now: u64) -> [f64; DOF] {
        let mut force = [0.0; DOF];
        if let (Cause::None, Some(f)) = (self.cause(now), &self.last) {
            for (to, from) in force.iter_mut().zip(&f.force[..f.n as usize]) {
                *to = f64::from(*from);
            }
        }
        force
    }

    /// Why there is no force at time `now` \[ns\], as seen from here; [`Cause::None`] where there is.
    pub fn cause(&self, now: u64) -> Cause {
        let Some(f) = &self.last else { return Cause::Disconnect };
        let life = (u64::from(f.ttl_us) * 1000).min(LONGEST_NS);
        // a frame of the future is of another clock
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

    fn watch() -> Watch {
        let mut w = Watch::new(crate::frame::uid("key"));
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
        // from another clock
        assert_eq!((w.force(10 * MS - 1), w.force(0)), ([0.0; DOF], [0.0; DOF]));
        // nothing lives longer than the longest
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
        let mut w = Watch::new(crate::frame::uid("key"));
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
        // and where nothing else comes, the end of the force has a reason
        assert_eq!(w.cause(6 * MS + 1), Cause::WatchdogOut);
    }
}
