//! The names and files of shared memory that a [`Site`](super::Site) is made from.
//!
//! These functions take a prefix or a folder, never a `Site`. Checks that need a `Site` are in `file_ownership.rs` and
//! `stale_shm.rs`.

pub(super) mod files;
pub(super) mod names;
pub(super) mod prefix;
