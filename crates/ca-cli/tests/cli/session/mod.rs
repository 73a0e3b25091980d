//! Tests of sessions: serving, takes and their replay, shared memory.

mod serve;
mod shm;
pub mod take;
