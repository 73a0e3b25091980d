//! `CLOCK_MONOTONIC` as a number, which the frames carry from process to process. `std::time::Instant` is the same
//! clock and hides the number; iceoryx2's own wrapper gives it without unsafe code of ours.

use iceoryx2_bb_posix::clock::{ClockType, Time};

/// Now \[ns\]; 0 where there is no such clock, which expires every force.
pub fn now_ns() -> u64 {
    Time::now_with_clock(ClockType::Monotonic).map_or(0, |t| t.seconds() * 1_000_000_000 + u64::from(t.nanoseconds()))
}

/// A number that no other process start has: random bits, never 0.
pub fn session() -> u64 {
    use std::hash::{BuildHasher, Hasher};
    let mut hash = std::collections::hash_map::RandomState::new().build_hasher();
    hash.write_u64(now_ns());
    hash.finish().max(1)
}
