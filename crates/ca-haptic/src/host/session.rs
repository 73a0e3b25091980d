//! What tells one start of a process from another.

use crate::rt::now_ns;
use std::hash::{BuildHasher, Hasher};

/// A number that no other process start has: random bits, never 0.
pub fn session() -> u64 {
    let mut hash = std::collections::hash_map::RandomState::new().build_hasher();
    hash.write_u64(now_ns());
    hash.finish().max(1)
}
