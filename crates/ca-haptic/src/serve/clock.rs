//! The clocks that gesture frames can follow, one at a time.
//!
//! The monotonic clock is for playing: frames are due one period apart, whatever devices do. A sound device is the
//! clock while sound goes straight to it: with any other clock, the ring between the two would run full or empty. With
//! a force device as the clock, each frame of the first device gives one frame of the engine, without slip. This is for
//! a device that drives everything, and for closed loops that must be reproducible. Without a device, time passes as on
//! the monotonic clock, so that a performance of given length ends.

#[cfg(feature = "system")]
use crate::rt::{Waits, now_ns};

/// The clock of the gesture frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Frames one period apart.
    Monotonic,
    /// Frames as the sound device of [`Rings::audio`](super::Rings::audio) needs them; one period apart without it.
    Audio,
    /// A frame with each frame of the first device, or after `patience`; that time counts as periods left out.
    Device {
        /// Longest wait for a frame \[ns\].
        patience: u64,
    },
}

/// Start of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Start {
    /// Delay \[ns\].
    pub late: u64,
    /// Periods left out before it.
    pub missed: u64,
}

#[cfg(feature = "system")]
/// Deadlines of the monotonic clock: `start + n·period`, not summed, so that a period of 333 333.3 ns does not drift.
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

    /// Waits for the next deadline. If it passed a whole period ago, the periods between are left out, so that no
    /// position of the hand is used for two frames.
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
/// Waits until `ready`, at most for `patience` \[ns\], in a loop with this `period` \[ns\]. Sleeps in pieces, because
/// the other side is another thread. After `patience`, the whole wait counts as periods left out.
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
    // sleeps at times, even if frames are always ready
    waits.pass();
    Start::default()
}

#[cfg(feature = "system")]
/// Returns the time to sleep before the next check of a ring, after `waited` of `patience` \[ns\]. It is an eighth of
/// the wait, which limits the delay of an answer, and at most 1 ms.
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
        // a frame that is ready is taken at once, and no period is left out
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
