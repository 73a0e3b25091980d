//! Devices and server over real shared memory, in threads and in separate processes.

mod control;
mod examples;
mod frames;
mod helpers;
mod processes;
mod services;
#[path = "../../../../tests/src/skipped.rs"]
mod skipped;
mod stale_shm;
