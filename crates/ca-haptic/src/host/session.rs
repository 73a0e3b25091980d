//! The session number, which distinguishes two starts of a process.

use crate::rt::now_ns;
use std::hash::{BuildHasher, Hasher};

/// Returns a number that differs from one process start to the next: random bits, never 0.
pub fn session_number() -> u64 {
    let mut hash = std::collections::hash_map::RandomState::new().build_hasher();
    hash.write_u64(now_ns());
    hash.finish().max(1)
}
