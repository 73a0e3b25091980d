//! Tests with real sound servers.

pub mod audio;
mod away;
mod pulse;
