//! The state of a scene: identity, plans, snapshots, scene swaps during play, long plays.

mod identity;
mod plan;
mod snapshot;
mod soak;
mod soak_space;
mod swap;
mod unstable;
