//! How a MIDI note or controller moves a port: the meaning of `midi = { … }` in a model file.
//!
//! Decides that the mapping is a plain record in the model, so that a Standard MIDI File is a gesture like any other:
//! it becomes breakpoints of position or force, never a hidden "note on" in the engine.

/// What moves the port.
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

/// What the velocity of a note says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Velocity {
    /// how far the port goes: `to` at 127
    #[default]
    Depth,
    /// how fast it goes, all the way to `to`: in `attack` at 127, with a fifth of that speed at the softest touch
    Speed,
    /// nothing: it goes all the way to `to` in `attack` at any
    None,
}

/// The mapping of one port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
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
    /// what the velocity of a note says
    pub velocity: Velocity,
    /// whether the port falls back after note off; where it does not, each note goes to the other side: a plectrum, which
    /// would pluck again on its way back
    pub back: bool,
}

impl MidiMap {
    /// A port that is moved by `source` on any channel, from 0 to 0, as fast as where nothing else is written.
    pub const fn new(source: MidiSource) -> MidiMap {
        let (attack, release) = (0.005, 0.03);
        MidiMap { source, channel: None, from: 0.0, to: 0.0, attack, release, velocity: Velocity::Depth, back: true }
    }
}
