//! `ca log` and `ca replay`: the contents of a take, and a take played again.

mod args;
pub mod log;
pub mod replay;

pub use args::{LogArgs, LogCommand, ReplayArgs};
