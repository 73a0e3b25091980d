//! Which clock the gesture frames follow.
//!
//! Decides on three, one at a time. The monotonic clock is the one for playing: frames fall due a period apart, whatever
//! devices do. Where sound goes straight to a device that plays it, that device's clock rules: no other keeps the ring
//! between the two from running full or dry. The device's own clock takes one frame of the first device for each frame
//! of the engine: no slip between the two, for a device that drives everything, and for closed loops that must be the
//! same every time. While no device is there, time passes as on the clock of the machine, so that a performance of a
//! given length ends.

#[cfg(feature = "system")]
use crate::rt::{Waits, now_ns};

/// The clock of the gesture frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// a period apart
    Monotonic,
    /// as the device needs it that plays the sound, [`Rings::audio`](super::Rings::audio); a period apart without one
    Audio,
    /// with each frame of the first device; without one for this long \[ns\], a frame all the same, and the time counts as
    /// periods left out
    Device {
        /// \[ns\]
        patience: u64,
    },
}

/// How a frame began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Start {
    /// how late it was \[ns\]
    pub late: u64,
    /// periods that were left out before it
    pub missed: u64,
}

#[cfg(feature = "system")]
/// Deadlines of the monotonic clock: `start + n·period`, never summed, so that a period of 333 333.3 ns does not drift.
pub(super) struct Pace {
    start: u64,
    period: f64,
    n: u64,
    waits: Waits,
}

#[cfg(feature = "system")]
impl Pace {
    pub(super) fn new(period: f64) -> Pace {
        Pace { start: now_ns(), period: period * 1e9, n: 0, waits: Waits::default() }
    }

    /// Waits for the next deadline. Where it is already a whole period past, the periods between are left out: no frame
    /// is computed twice for one position of the hand.
    pub(super) fn next(&mut self) -> Start {
        self.n += 1;
        let due = self.start + (self.n as f64 * self.period) as u64;
        let late = self.waits.until(due) - due;
        let missed = (late as f64 / self.period) as u64;
        self.n += missed;
        Start { late, missed }
    }
}

#[cfg(feature = "system")]
/// Waits until `ready`, at most `patience` \[ns\], for a loop of this `period` \[ns\]. Sleeps in pieces, since the other
/// side is another thread; a wait in vain took as many periods as it lasted.
pub(super) fn wait_for(waits: &mut Waits, patience: u64, period: f64, mut ready: impl FnMut() -> bool) -> Start {
    let begin = now_ns();
    let mut now = begin;
    while !ready() {
        if now - begin >= patience {
            let late = now - begin;
            return Start { late, missed: (late as f64 / period) as u64 };
        }
        waits.sleep(now + piece(now - begin, patience));
        now = now_ns();
    }
    // one that is always ready is no reason never to sleep
    waits.pass();
    Start::default()
}

#[cfg(feature = "system")]
/// How long to sleep before the next look at a ring, after a wait of `waited` of `patience` \[ns\]: an eighth of the
/// wait, so that an answer is seen late by as much at most, and a device that never comes costs a look a millisecond.
fn piece(waited: u64, patience: u64) -> u64 {
    (waited / 8).clamp(20_000, 1_000_000).min(patience - waited)
}

#[cfg(all(test, feature = "system"))]
mod tests {
    use super::*;

    #[test]
    fn a_wait_in_vain_looks_seldom_and_counts_as_what_it_lasted() {
        let (mut looks, mut waits) = (0, Waits::default());
        let start = wait_for(&mut waits, 100_000_000, 333_333.3, || {
            looks += 1;
            false
        });
        assert!(looks <= 150, "{looks} looks in a tenth of a second");
        assert!(start.late >= 100_000_000 && start.missed >= 300, "{start:?}");
        assert_eq!(start.missed, (start.late as f64 / 333_333.3) as u64);
        // what is there is taken at once, and no period is left out for it
        assert_eq!(wait_for(&mut waits, 100_000_000, 333_333.3, || true), Start::default());
        assert_eq!(wait_for(&mut waits, 0, 333_333.3, || false).missed, 0);
    }

    #[test]
    fn no_piece_is_nothing_or_longer_than_an_eighth_or_what_is_left() {
        for waited in [0, 1, 100_000, 160_000, 333_333, 8_000_000, 50_000_000, 99_999_999] {
            let p = piece(waited, 100_000_000);
            assert!(p > 0 && p <= 1_000_000.min(100_000_000 - waited), "{p} after {waited}");
            assert!(p <= 20_000.max(waited / 8), "{p} after {waited}");
        }
    }
}
