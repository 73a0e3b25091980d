//! Mapping of a MIDI note or controller to a port: the meaning of `midi = { … }` in a model file.
//!
//! The mapping is a plain record in the model, so that a Standard MIDI File is a gesture like any other. It becomes
//! breakpoints of position or force, never a hidden "note on" in the engine.

/// MIDI event that moves the port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum MidiSource {
    /// notes `low ..= high` (0 to 127)
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

/// Meaning of the velocity of a note.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Velocity {
    /// distance: the port moves to `to` at velocity 127
    #[default]
    Depth,
    /// speed: the port always moves to `to`, in `attack` at velocity 127 and at a fifth of that speed at the softest
    Speed,
    /// none: the port moves to `to` in `attack` at any velocity
    None,
}

/// The mapping of one port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct MidiMap {
    /// event that moves it
    pub source: MidiSource,
    /// channel, 1 to 16; all channels if `None`
    pub channel: Option<u8>,
    /// value at rest (controller 0, note off), in the unit of the port \[m\] or \[N\]
    pub from: f64,
    /// value at full scale (controller at maximum, velocity 127), in the unit of the port
    pub to: f64,
    /// time to reach a new value \[s\]; the way is linear
    pub attack: f64,
    /// time to fall back after note off \[s\]; the way is linear
    pub release: f64,
    /// meaning of the velocity of a note
    pub velocity: Velocity,
    /// whether the port returns after note off; if not, each note moves it to the other side, as a plectrum
    pub back: bool,
}

impl MidiMap {
    /// Makes a port moved by `source` on any channel, from 0 to 0, with the default attack and release.
    pub const fn new(source: MidiSource) -> MidiMap {
        let (attack, release) = (0.005, 0.03);
        MidiMap { source, channel: None, from: 0.0, to: 0.0, attack, release, velocity: Velocity::Depth, back: true }
    }
}
