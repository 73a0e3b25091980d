//! How a MIDI note or controller moves a port: the meaning of `midi = { … }` in a model file.
//!
//! Decides that the mapping is a plain record in the model, so that a Standard MIDI File is a gesture like any other:
//! it becomes breakpoints of position or force, never a hidden "note on" in the engine.

/// What moves the port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MidiSource {
    /// notes `low ..= high` (0 to 127); the velocity scales the way from `from` to `to`
    Note {
        /// lowest note number
        low: u8,
        /// highest note number
        high: u8,
    },
    /// a continuous controller, by number
    Control(u8),
    /// pitch bend, 14 bits
    PitchBend,
    /// channel pressure
    Pressure,
}

/// The mapping of one port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MidiMap {
    /// what moves it
    pub source: MidiSource,
    /// 1 to 16; all channels if `None`
    pub channel: Option<u8>,
    /// value at rest (controller 0, note off), in the unit of the port \[m\] or \[N\]
    pub from: f64,
    /// value at full scale (controller at maximum, velocity 127), in the unit of the port
    pub to: f64,
    /// time to reach a new value \[s\]; the way is linear
    pub attack: f64,
    /// time to fall back after note off \[s\]; the way is linear
    pub release: f64,
}
