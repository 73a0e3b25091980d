//! `ca log` and `ca replay`: the contents of a take, and a take played again.

pub mod log;
pub mod replay;
