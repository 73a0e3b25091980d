//! `ca log` and `ca replay`: contents and replay of a take.

mod args;
pub mod log;
pub mod replay;

pub use args::{LogArgs, LogCommand, ReplayArgs};
