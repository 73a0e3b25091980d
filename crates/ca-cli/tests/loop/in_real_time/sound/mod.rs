//! Sound servers, each a real one.

pub mod audio;
mod away;
mod pulse;
