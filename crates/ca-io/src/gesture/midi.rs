//! Standard MIDI Files as gestures: events become breakpoints of position or force, port by port.
//!
//! Decides that a port is monophonic. Of overlapping notes the newest wins, and its release falls back to the newest
//! still held; a key that is struck again while down is one key. A glide starts from wherever the port is at that
//! moment, so nothing ever jumps unless `attack` or `release` is 0. The sustain pedal is a controller like others.
//! Polyphony is many ports with a note each, which is how an instrument of strings is built anyway.
//!
//! Before its first event a port stands at `from`, a pitch bend midway (the middle of its 14 bits is the middle of the
//! way, both ends are reached exactly). Ports which the file does not move rest there throughout; that it moves none
//! at all is an error which lists what it has.
//!
//! Times are exact: ticks and the tempo map are summed as integers, and divided once per event. A file that is cut
//! short or malformed is an error; the parser below would drop the rest of a track without a word.

use super::smf::{self, Event};
use super::{Gesture, PortMap, Track};
use crate::error::FileError;
use ca_core::io::midi::{MidiMap, MidiSource};
use ca_model::quantity::Plain;
use midly::MidiMessage;
use std::collections::{BTreeMap, BTreeSet};

/// Reads a Standard MIDI File for these ports.
pub(super) fn read(bytes: &[u8], ports: &[PortMap]) -> Result<Gesture, FileError> {
    if ports.is_empty() {
        let e = FileError::usage("no port of the model listens to MIDI");
        return Err(e.fix("give a port a `midi = { … }`, with the notes or the controller that move it"));
    }
    ports.iter().try_for_each(check)?;
    let events = smf::events(bytes)?;
    let mut port_tracks: Vec<PortTrack> = ports.iter().map(|p| PortTrack::new(&p.map)).collect();
    for e in &events {
        for f in &mut port_tracks {
            f.event(e);
        }
    }
    if !port_tracks.iter().any(|f| f.touched) {
        let wanted: Vec<String> = ports.iter().map(|p| format!("`{}` ({})", p.port, wants(&p.map))).collect();
        let e = FileError::content(format!("nothing in it moves {}: it has {}", list(&wanted), inventory(&events)));
        return Err(e.fix("change `midi` of a port to what the file has"));
    }
    let tracks = ports.iter().zip(port_tracks).map(|(p, f)| Track::points(&p.port, f.finish()));
    Gesture::new(tracks.collect::<Result<_, _>>()?)
}

fn check(p: &PortMap) -> Result<(), FileError> {
    let m = &p.map;
    let times = [("attack", m.attack), ("release", m.release)];
    if let Some((name, t)) = times.iter().find(|(_, t)| !(0.0..=super::LONGEST).contains(t)) {
        let e = FileError::usage(format!("port `{}`: `{name}` is {} s", p.port, Plain(*t)));
        return Err(e.fix("give a time that is not negative"));
    }
    if !(m.from.is_finite() && m.to.is_finite()) {
        return Err(FileError::usage(format!("port `{}`: goes from {} to {}", p.port, m.from, m.to)));
    }
    Ok(())
}

/// One port while the events go by.
struct PortTrack<'a> {
    map: &'a MidiMap,
    points: Vec<(f64, f64)>,
    /// the glide under way: start and end
    glide: Option<((f64, f64), (f64, f64))>,
    /// value when no glide is under way
    rest: f64,
    /// notes held: channel, key, velocity; the newest last
    held: Vec<(u8, u8, u8)>,
    touched: bool,
}

impl<'a> PortTrack<'a> {
    fn new(map: &'a MidiMap) -> PortTrack<'a> {
        let rest = if map.source == MidiSource::PitchBend { way(map, 0.5) } else { map.from };
        PortTrack { map, points: Vec::new(), glide: None, rest, held: Vec::new(), touched: false }
    }

    fn event(&mut self, e: &Event) {
        let map = self.map;
        if map.channel.is_some_and(|c| c != e.channel) {
            return;
        }
        match (map.source, e.message) {
            (MidiSource::Note { low, high }, MidiMessage::NoteOn { key, vel }) => {
                let key = key.as_int();
                if !(low..=high).contains(&key) {
                    return;
                }
                if vel == 0 {
                    return self.release(e, |n| (n.0, n.1) == (e.channel, key));
                }
                self.held.retain(|n| (n.0, n.1) != (e.channel, key));
                self.held.push((e.channel, key, vel.as_int()));
                self.go(e.time, way(map, f64::from(vel.as_int()) / 127.0), map.attack);
            }
            (MidiSource::Note { .. }, MidiMessage::NoteOff { key, .. }) => {
                self.release(e, |n| (n.0, n.1) == (e.channel, key.as_int()));
            }
            // all sound off, all notes off
            (MidiSource::Note { .. }, MidiMessage::Controller { controller, .. })
                if matches!(controller.as_int(), 120 | 123) =>
            {
                self.release(e, |n| n.0 == e.channel);
            }
            (MidiSource::Control(n), MidiMessage::Controller { controller, value }) if controller == n => {
                self.go(e.time, way(map, f64::from(value.as_int()) / 127.0), map.attack);
            }
            (MidiSource::Pressure, MidiMessage::ChannelAftertouch { vel }) => {
                self.go(e.time, way(map, f64::from(vel.as_int()) / 127.0), map.attack);
            }
            (MidiSource::PitchBend, MidiMessage::PitchBend { bend }) => {
                let b = f64::from(bend.0.as_int()) - 8192.0;
                self.go(e.time, way(map, 0.5 + 0.5 * b / if b < 0.0 { 8192.0 } else { 8191.0 }), map.attack);
            }
            _ => {}
        }
    }

    /// Lets go of some notes; if the newest is among them, back to the newest still held, or to rest.
    fn release(&mut self, e: &Event, gone: impl Fn(&(u8, u8, u8)) -> bool) {
        let newest = self.held.last().copied();
        self.held.retain(|n| !gone(n));
        if newest == self.held.last().copied() {
            return;
        }
        match self.held.last() {
            Some(n) => self.go(e.time, way(self.map, f64::from(n.2) / 127.0), self.map.attack),
            None => self.go(e.time, self.map.from, self.map.release),
        }
    }

    /// From where the port is at `time` to `target`, in `over` seconds.
    fn go(&mut self, time: f64, target: f64, over: f64) {
        self.touched = true;
        let here = self.settle(time);
        self.push((time, here));
        self.glide = Some(((time, here), (time + over, target)));
    }

    /// Ends the glide at `time` at the latest, and says where the port is then.
    fn settle(&mut self, time: f64) -> f64 {
        if let Some(((t0, a), (t1, b))) = self.glide.take() {
            if t1 <= time {
                self.push((t1, b));
                self.rest = b;
            } else {
                let u = (time - t0) / (t1 - t0);
                self.rest = a * (1.0 - u) + b * u;
            }
        }
        self.rest
    }

    fn push(&mut self, point: (f64, f64)) {
        if self.points.last() != Some(&point) {
            self.points.push(point);
        }
    }

    fn finish(mut self) -> Vec<(f64, f64)> {
        self.settle(f64::INFINITY);
        if self.points.is_empty() {
            self.points.push((0.0, self.rest));
        }
        self.points
    }
}

/// The value at a part of the way, exact at both ends.
fn way(m: &MidiMap, part: f64) -> f64 {
    if part >= 1.0 { m.to } else { m.from + (m.to - m.from) * part }
}

fn wants(m: &MidiMap) -> String {
    let what = match m.source {
        MidiSource::Note { low, high } => format!("notes {low} to {high}"),
        MidiSource::Control(n) => format!("controller {n}"),
        MidiSource::PitchBend => "pitch bend".to_owned(),
        MidiSource::Pressure => "channel pressure".to_owned(),
    };
    m.channel.map_or(what.clone(), |c| format!("{what}, channel {c}"))
}

/// What the file has, channel by channel.
fn inventory(events: &[Event]) -> String {
    #[derive(Default)]
    struct Has {
        notes: Option<(u8, u8)>,
        controllers: BTreeSet<u8>,
        bend: bool,
        pressure: bool,
    }
    let mut channels: BTreeMap<u8, Has> = BTreeMap::new();
    for e in events {
        let has = channels.entry(e.channel).or_default();
        match e.message {
            MidiMessage::NoteOn { key, .. } => {
                let k = key.as_int();
                has.notes = Some(has.notes.map_or((k, k), |(l, h)| (l.min(k), h.max(k))));
            }
            MidiMessage::Controller { controller, .. } => {
                has.controllers.insert(controller.as_int());
            }
            MidiMessage::PitchBend { .. } => has.bend = true,
            MidiMessage::ChannelAftertouch { .. } => has.pressure = true,
            _ => {}
        }
    }
    let mut said = Vec::new();
    for (channel, has) in channels {
        let mut parts = Vec::new();
        parts.extend(has.notes.map(|(l, h)| format!("notes {l} to {h}")));
        match has.controllers.len() {
            0 => {}
            1 => parts.extend(has.controllers.iter().map(|c| format!("controller {c}"))),
            _ => parts
                .push(format!("controllers {}", list(&has.controllers.iter().map(u8::to_string).collect::<Vec<_>>()))),
        }
        parts.extend(has.bend.then(|| "pitch bend".to_owned()));
        parts.extend(has.pressure.then(|| "channel pressure".to_owned()));
        if !parts.is_empty() {
            said.push(format!("{} on channel {channel}", list(&parts)));
        }
    }
    if said.is_empty() { "no notes or controllers".to_owned() } else { said.join(", ") }
}

/// `a, b and c`.
fn list(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

#[cfg(test)]
#[path = "midi_tests.rs"]
mod tests;
