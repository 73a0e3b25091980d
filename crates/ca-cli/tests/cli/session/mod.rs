//! What is played: servers, takes, shared memory.

mod serve;
mod shm;
pub mod take;
