//! One port that MIDI moves: what each event asks of it, in a file or while it is played.
//!
//! Decides that a port is monophonic. Of overlapping notes the newest wins, and its release falls back to the newest
//! still held; a key that is struck again while down is one key. One that notes do not bring back (`back = false`) goes to its other
//! side with each. The sustain pedal is a controller like others.
//! Polyphony is many ports with a note each, which is how an instrument of strings is built anyway.

use ca_core::io::midi::{MidiMap, MidiSource, Velocity};
use midly::MidiMessage;

/// Where a port goes from wherever it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glide {
    /// its value there, in the unit of the port
    pub to: f64,
    /// the time that takes \[s\]
    pub over: f64,
}

/// A port with the notes that are held on it.
#[derive(Clone, Debug)]
pub struct MidiPort {
    map: MidiMap,
    /// notes held: channel, key, velocity; the newest last
    held: Vec<(u8, u8, u8)>,
    /// where notes do not bring it back: it is at the far side
    far: bool,
}

impl MidiPort {
    /// With no note held.
    pub fn new(map: &MidiMap) -> MidiPort {
        MidiPort { map: *map, held: Vec::new(), far: false }
    }

    /// Where it stands before its first event: at `from`, a pitch bend midway.
    pub fn rest(&self) -> f64 {
        if self.map.source == MidiSource::PitchBend { self.way(0.5) } else { self.map.from }
    }

    /// An event on a channel, from 1; `None` where the port stays where it goes.
    pub fn event(&mut self, channel: u8, message: MidiMessage) -> Option<Glide> {
        if self.map.channel.is_some_and(|c| c != channel) {
            return None;
        }
        match (self.map.source, message) {
            (MidiSource::Note { low, high }, MidiMessage::NoteOn { key, vel }) => {
                let key = key.as_int();
                if !(low..=high).contains(&key) {
                    return None;
                }
                if vel == 0 {
                    return self.release(|n| (n.0, n.1) == (channel, key));
                }
                self.held.retain(|n| (n.0, n.1) != (channel, key));
                self.held.push((channel, key, vel.as_int()));
                if !self.map.back {
                    self.far = !self.far;
                }
                Some(self.note(vel.as_int()))
            }
            (MidiSource::Note { .. }, MidiMessage::NoteOff { key, .. }) => {
                self.release(|n| (n.0, n.1) == (channel, key.as_int()))
            }
            // all sound off, all notes off
            (MidiSource::Note { .. }, MidiMessage::Controller { controller, .. })
                if matches!(controller.as_int(), 120 | 123) =>
            {
                self.release(|n| n.0 == channel)
            }
            (MidiSource::Control(n), MidiMessage::Controller { controller, value }) if controller == n => {
                Some(self.go(value.as_int()))
            }
            (MidiSource::Pressure, MidiMessage::ChannelAftertouch { vel }) => Some(self.go(vel.as_int())),
            (MidiSource::PitchBend, MidiMessage::PitchBend { bend }) => {
                let b = f64::from(bend.0.as_int()) - 8192.0;
                let to = self.way(0.5 + 0.5 * b / if b < 0.0 { 8192.0 } else { 8191.0 });
                Some(Glide { to, over: self.map.attack })
            }
            _ => None,
        }
    }

    /// Lets go of some notes; if the newest is among them, back to the newest still held, or to rest.
    fn release(&mut self, gone: impl Fn(&(u8, u8, u8)) -> bool) -> Option<Glide> {
        let newest = self.held.last().copied();
        self.held.retain(|n| !gone(n));
        if newest == self.held.last().copied() || !self.map.back {
            return None;
        }
        Some(match self.held.last() {
            Some(n) => self.note(n.2),
            None => Glide { to: self.map.from, over: self.map.release },
        })
    }

    /// Where a note of this velocity brings it, from 1 on.
    fn note(&self, velocity: u8) -> Glide {
        let part = f64::from(velocity) / 127.0;
        let (far, over) = match self.map.velocity {
            Velocity::Depth => (self.way(part), self.map.attack),
            Velocity::Speed => (self.map.to, self.map.attack / part),
            Velocity::None => (self.map.to, self.map.attack),
        };
        Glide { to: if self.map.back || self.far { far } else { self.map.from }, over }
    }

    fn go(&self, value: u8) -> Glide {
        Glide { to: self.way(f64::from(value) / 127.0), over: self.map.attack }
    }

    /// The value at a part of the way, exact at both ends.
    fn way(&self, part: f64) -> f64 {
        let m = &self.map;
        if part >= 1.0 { m.to } else { m.from + (m.to - m.from) * part }
    }
}
