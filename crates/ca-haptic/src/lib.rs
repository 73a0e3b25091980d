//! What surrounds a scene: gestures in, sound files out; later devices, frames, the guard, the real-time thread and
//! MCAP takes.
#![forbid(unsafe_code)]

pub mod error;
pub mod gesture;

pub use error::{FileError, FileErrorKind};
