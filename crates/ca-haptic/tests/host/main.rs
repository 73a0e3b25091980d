//! Devices and server over real shared memory, in threads and in separate processes.

mod control;
mod desk;
mod examples;
mod frames;
mod lines;
mod processes;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod stale_shm;
