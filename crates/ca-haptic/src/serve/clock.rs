//! Which clock the gesture frames follow.
//!
//! Decides on three, one at a time. The monotonic clock is the one for playing: frames fall due a period apart, whatever
//! devices do. Where sound goes straight to a device that plays it, that device's clock rules: no other keeps the ring
//! between the two from running full or dry. The device's own clock takes one frame of the first device for each frame
//! of the engine: no slip between the two, for a device that drives everything, and for closed loops that must be the
//! same every time.

use crate::rt::{Waits, now_ns, wait_until};

/// The clock of the gesture frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// a period apart
    Monotonic,
    /// as the device needs it that plays the sound, [`Rings::audio`](super::Rings::audio); a period apart without one
    Audio,
    /// with each frame of the first device; without one for this long \[ns\], a frame all the same
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

/// Deadlines of the monotonic clock: `start + n·period`, never summed, so that a period of 333 333.3 ns does not drift.
pub(super) struct Pace {
    start: u64,
    period: f64,
    n: u64,
    waits: Waits,
}

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

/// Waits until `ready`, at most `patience` \[ns\]. Sleeps in short pieces: the other side is another thread.
pub(super) fn wait_for(patience: u64, mut ready: impl FnMut() -> bool) -> Start {
    let begin = now_ns();
    loop {
        if ready() {
            return Start::default();
        }
        let now = now_ns();
        if now - begin >= patience {
            return Start { late: now - begin, missed: 1 };
        }
        wait_until(now + PIECE);
    }
}

/// Between two looks at a ring \[ns\]: longer than a wait spins, so that it sleeps.
const PIECE: u64 = 100_000;
