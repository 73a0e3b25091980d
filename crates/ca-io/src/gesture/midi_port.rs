//! Motion of one port by MIDI events, from a file or live.
//!
//! A port is monophonic. Of overlapping notes the newest wins, and its release falls back to the newest note still
//! held. A key struck again while down counts as one key. With `back = false`, each note moves the port to its other
//! side. Polyphony needs a port for each note, as in an instrument of strings.
//!
//! The sustain pedal (controller 64, down from value 64) holds the notes of its channel, unless that controller itself
//! moves a port of the model. A port held only by the pedal returns to rest before the next note, since it could not be
//! struck where it is.

use super::PortMap;
use ca_core::internal::io::midi::{MidiMap, MidiSource, Velocity};
use midly::MidiMessage;

/// Controllers with a fixed meaning in every model.
const SUSTAIN: u8 = 64;
const ALL_SOUND_OFF: u8 = 120;
const RESET_CONTROLLERS: u8 = 121;
const ALL_NOTES_OFF: u8 = 123;

/// Speed of a key at the softest touch, as a share of the speed at velocity 127: the hammer still arrives, about 30 dB
/// below the loudest.
const SOFTEST: f64 = 0.2;

/// Straight motion from the present value of the port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glide {
    /// Value at the end, in the unit of the port.
    pub to: f64,
    /// Duration \[s\].
    pub over: f64,
}

/// Motion of a port after an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Return to rest before the glide, if only the pedal held the port.
    pub lift: Option<Glide>,
    /// Motion to the new value.
    pub glide: Glide,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Held {
    channel: u8,
    key: u8,
    velocity: u8,
    /// True if held by its key, false if by the pedal.
    pressed: bool,
}

impl Held {
    fn is(self, channel: u8, key: u8) -> bool {
        (self.channel, self.key) == (channel, key)
    }
}

/// A port with its held notes.
#[derive(Clone, Debug)]
pub struct MidiPort {
    map: MidiMap,
    /// Held notes, the newest last.
    held: Vec<Held>,
    /// With `back = false`: the port is at the far side.
    far: bool,
    /// True if the pedal holds notes in this model.
    sustains: bool,
    /// Channels whose pedal is down, a bit each.
    pedals: u32,
}

impl MidiPort {
    /// Makes the ports of a model, with no note held.
    pub fn all(ports: &[PortMap]) -> Vec<MidiPort> {
        let sustains = ports.iter().all(|p| p.map.source != MidiSource::Control(SUSTAIN));
        ports.iter().map(|p| MidiPort { map: p.map, held: Vec::new(), far: false, sustains, pedals: 0 }).collect()
    }

    /// Returns the value before the first event: `from`, or the middle for a pitch bend.
    pub fn rest(&self) -> f64 {
        if self.map.source == MidiSource::PitchBend { self.way(0.5) } else { self.map.from }
    }

    /// Returns true if the port follows events of this kind on a channel (from 1). This event may leave it in place.
    pub fn follows(&self, channel: u8, message: MidiMessage) -> bool {
        self.map.channel.is_none_or(|c| c == channel)
            && match (self.map.source, message) {
                (
                    MidiSource::Note { low, high },
                    MidiMessage::NoteOn { key, .. } | MidiMessage::NoteOff { key, .. },
                ) => (low..=high).contains(&key.as_int()),
                (MidiSource::Note { .. }, MidiMessage::Controller { controller, .. }) => match controller.as_int() {
                    SUSTAIN => self.sustains && self.map.back,
                    n => matches!(n, ALL_SOUND_OFF | RESET_CONTROLLERS | ALL_NOTES_OFF),
                },
                (MidiSource::Control(n), MidiMessage::Controller { controller, .. }) => controller == n,
                (MidiSource::Pressure, MidiMessage::ChannelAftertouch { .. })
                | (MidiSource::PitchBend, MidiMessage::PitchBend { .. }) => true,
                _ => false,
            }
    }

    /// Processes an event on a channel (from 1); returns `None` if the motion of the port does not change.
    pub fn event(&mut self, channel: u8, message: MidiMessage) -> Option<Motion> {
        if !self.follows(channel, message) {
            return None;
        }
        let glide = match message {
            MidiMessage::NoteOn { key, vel } if vel > 0 => {
                return Some(self.strike(channel, key.as_int(), vel.as_int()));
            }
            MidiMessage::NoteOn { key, .. } | MidiMessage::NoteOff { key, .. } => {
                self.let_go(channel, |n| n.is(channel, key.as_int()))?
            }
            MidiMessage::Controller { controller, value } => match (self.map.source, controller.as_int()) {
                (MidiSource::Control(_), _) => self.go(value.as_int()),
                (_, SUSTAIN) => self.pedal(channel, value >= 64)?,
                (_, RESET_CONTROLLERS) => self.pedal(channel, false)?,
                (_, ALL_NOTES_OFF) => self.let_go(channel, |n| n.channel == channel)?,
                _ => self.release(|n| n.channel == channel)?,
            },
            MidiMessage::ChannelAftertouch { vel } => self.go(vel.as_int()),
            MidiMessage::PitchBend { bend } => {
                let b = f64::from(bend.0.as_int()) - 8192.0;
                let to = self.way(0.5 + 0.5 * b / if b < 0.0 { 8192.0 } else { 8191.0 });
                Glide { to, over: self.map.attack }
            }
            _ => return None,
        };
        Some(Motion { lift: None, glide })
    }

    fn strike(&mut self, channel: u8, key: u8, velocity: u8) -> Motion {
        let sustained = !self.held.is_empty() && self.held.iter().all(|n| !n.pressed);
        self.held.retain(|n| !n.is(channel, key));
        self.held.push(Held { channel, key, velocity, pressed: true });
        if !self.map.back {
            self.far = !self.far;
        }
        Motion { lift: (sustained && self.map.back).then(|| self.up()), glide: self.note(velocity) }
    }

    /// Releases keys; the pedal may go on holding their notes.
    fn let_go(&mut self, channel: u8, up: impl Fn(&Held) -> bool) -> Option<Glide> {
        if (self.pedals >> channel) & 1 == 0 {
            return self.release(up);
        }
        self.held.iter_mut().filter(|n| up(n)).for_each(|n| n.pressed = false);
        None
    }

    fn pedal(&mut self, channel: u8, down: bool) -> Option<Glide> {
        let bit = 1_u32 << channel;
        if down {
            self.pedals |= bit;
            return None;
        }
        self.pedals &= !bit;
        self.release(|n| n.channel == channel && !n.pressed)
    }

    /// Ends some notes. If the newest is among them, the port goes to the newest note still held, or to rest.
    fn release(&mut self, gone: impl Fn(&Held) -> bool) -> Option<Glide> {
        let newest = self.held.last().copied();
        self.held.retain(|n| !gone(n));
        if newest == self.held.last().copied() || !self.map.back {
            return None;
        }
        Some(match self.held.last() {
            Some(n) => self.note(n.velocity),
            None => self.up(),
        })
    }

    fn up(&self) -> Glide {
        Glide { to: self.map.from, over: self.map.release }
    }

    /// Returns the motion for a note of this velocity, from 1.
    fn note(&self, velocity: u8) -> Glide {
        let part = f64::from(velocity) / 127.0;
        let (far, over) = match self.map.velocity {
            Velocity::Depth => (self.way(part), self.map.attack),
            Velocity::Speed => (self.map.to, self.map.attack / (SOFTEST + (1.0 - SOFTEST) * part)),
            Velocity::None => (self.map.to, self.map.attack),
        };
        Glide { to: if self.map.back || self.far { far } else { self.map.from }, over }
    }

    fn go(&self, value: u8) -> Glide {
        Glide { to: self.way(f64::from(value) / 127.0), over: self.map.attack }
    }

    /// Returns the value at a share of the range, exact at both ends.
    fn way(&self, part: f64) -> f64 {
        let m = &self.map;
        if part >= 1.0 { m.to } else { m.from + (m.to - m.from) * part }
    }
}
