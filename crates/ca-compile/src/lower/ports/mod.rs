//! Ports, their MIDI, and gestures.

pub mod gesture;
pub mod midi;
pub mod port;
