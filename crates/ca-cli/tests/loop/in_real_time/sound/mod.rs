//! Tests with real sound servers.

pub mod audio;
mod pulse;
mod server_loss;
