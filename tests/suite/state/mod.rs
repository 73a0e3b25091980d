//! The state of a scene: identity, snapshots, changed scenes while they play, long plays.

mod identity;
mod plan;
mod snapshot;
mod soak;
mod swap;
