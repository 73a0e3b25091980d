//! Standard MIDI Files as gestures: turns events into breakpoints of position or force, port by port.
//!
//! An event moves a port as it does live ([`MidiPort`]). A glide starts from the position of the port at that moment,
//! so nothing jumps unless `attack` or `release` is 0.
//!
//! Before its first event a port rests at `from`, or for a pitch bend at the middle of its range; the middle of the 14
//! bits is exactly the middle of the range, and both ends are reached exactly. Ports that the file does not move rest
//! there throughout. A file that moves no port is an error, which lists the events in the file.
//!
//! Times are exact: ticks and the tempo map are summed as integers, and divided once per event. A truncated or
//! malformed file is an error; midly alone would silently drop the rest of a track.

use super::midi_port::{Glide, MidiPort, Motion};
use super::smf::{self, Event};
use super::{Gesture, PortMap, Track};
use crate::error::FileError;
use ca_core::internal::io::midi::{MidiMap, MidiSource};
use ca_core::internal::numeric::Plain;
use midly::MidiMessage;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

pub(super) fn read(bytes: &[u8], ports: &[PortMap]) -> Result<Gesture, FileError> {
    if ports.is_empty() {
        let e = FileError::usage("no port of the model receives MIDI");
        return Err(e.fix("give a port a `midi = { … }`, with the notes or the controller that move it"));
    }
    ports.iter().try_for_each(check)?;
    let smf::Messages { events, mut remarks } = smf::messages(bytes)?;
    let mut port_tracks: Vec<PortTrack> = MidiPort::all(ports).into_iter().map(PortTrack::new).collect();
    let mut ignored = Vec::new();
    for e in &events {
        if !port_tracks.iter().any(|f| f.port.follows(e.channel, e.message)) {
            ignored.push(*e);
        }
        for f in &mut port_tracks {
            f.event(e);
        }
    }
    if !port_tracks.iter().any(|f| f.touched) {
        let wanted: Vec<String> = ports.iter().map(|p| format!("`{}` ({})", p.port, wants(&p.map))).collect();
        let found = inventory(&events).unwrap_or_else(|| "no notes or controllers".into());
        let e = FileError::content(format!("no event in it moves {}: it has {}", list(&wanted), found));
        return Err(e.fix("change `midi` of a port to notes or a controller of the file"));
    }
    let tracks = ports.iter().zip(port_tracks).map(|(p, f)| Track::points(&p.port, f.finish()));
    remarks.extend(unheard(&ignored));
    // channel mode messages need no port
    ignored.retain(|e| !matches!(e.message, MidiMessage::NoteOn { .. }) && !is_order(e.message));
    remarks.extend(inventory(&ignored).map(|what| format!("no port follows {what}")));
    Ok(Gesture { remarks, midi: true, ..Gesture::new(tracks.collect::<Result<_, _>>()?)? })
}

/// Returns true for a channel mode message, such as all notes off.
fn is_order(message: MidiMessage) -> bool {
    matches!(message, MidiMessage::Controller { controller, .. } if controller.as_int() >= 120)
}

fn unheard(ignored: &[Event]) -> Option<String> {
    let mut all: BTreeMap<u8, BTreeMap<u8, usize>> = BTreeMap::new();
    for e in ignored {
        let MidiMessage::NoteOn { key, vel } = e.message else { continue };
        if vel > 0 {
            *all.entry(e.channel).or_default().entry(key.as_int()).or_default() += 1;
        }
    }
    let times: usize = all.values().flat_map(BTreeMap::values).sum();
    let of = |(channel, notes): (&u8, &BTreeMap<u8, usize>)| {
        let shown: Vec<String> = notes.keys().take(SHOWN).map(u8::to_string).collect();
        let rest = if notes.len() > SHOWN { format!(" and {} others", notes.len() - SHOWN) } else { String::new() };
        format!("{}{rest} on channel {channel}", shown.join(", "))
    };
    let notes: Vec<String> = all.iter().map(of).collect();
    let what = if times == 1 { "1 note moves".into() } else { format!("{times} notes move") };
    (times > 0).then(|| format!("{what} no port: {}", notes.join("; ")))
}

/// Largest number of ignored notes that are listed.
const SHOWN: usize = 12;

fn check(p: &PortMap) -> Result<(), FileError> {
    let m = &p.map;
    let times = [("attack", m.attack), ("release", m.release)];
    if let Some((name, t)) = times.iter().find(|(_, t)| !(0.0..=super::LONGEST).contains(t)) {
        let e = FileError::usage(format!("port `{}`: `{name}` is {} s, which is out of range", p.port, Plain(*t)));
        return Err(e.fix("give a time from 0 s to 86400 s"));
    }
    if !(m.from.is_finite() && m.to.is_finite()) {
        return Err(FileError::usage(format!(
            "port `{}`: the range from {} to {} is not finite",
            p.port, m.from, m.to
        )));
    }
    Ok(())
}

/// A port and its breakpoints so far.
struct PortTrack {
    port: MidiPort,
    points: Vec<(f64, f64)>,
    /// Straight segments still to go, in order: start and end, each a time and a value.
    ways: VecDeque<[(f64, f64); 2]>,
    /// Value while no segment is left.
    rest: f64,
    touched: bool,
}

impl PortTrack {
    fn new(port: MidiPort) -> PortTrack {
        PortTrack { rest: port.rest(), port, points: Vec::new(), ways: VecDeque::new(), touched: false }
    }

    fn event(&mut self, e: &Event) {
        let Some(Motion { lift, glide }) = self.port.event(e.channel, e.message) else { return };
        self.touched = true;
        let mut here = (e.time, self.settle(e.time));
        self.push(here);
        for Glide { to, over } in lift.into_iter().chain([glide]) {
            let there = (here.0 + over, to);
            self.ways.push_back([here, there]);
            here = there;
        }
    }

    /// Moves on until `time`, drops the remaining segments, and returns the value of the port.
    fn settle(&mut self, time: f64) -> f64 {
        while let Some([(t0, a), (t1, b)]) = self.ways.pop_front() {
            if t1 <= time {
                self.push((t1, b));
                self.rest = b;
            } else {
                let u = (time - t0) / (t1 - t0);
                self.rest = a * (1.0 - u) + b * u;
                self.ways.clear();
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

fn wants(m: &MidiMap) -> String {
    let what = match m.source {
        MidiSource::Note { low, high } => format!("notes {low} to {high}"),
        MidiSource::Control(n) => format!("controller {n}"),
        MidiSource::PitchBend => "pitch bend".to_owned(),
        MidiSource::Pressure => "channel pressure".to_owned(),
    };
    m.channel.map_or(what.clone(), |c| format!("{what}, channel {c}"))
}

/// Lists these events by channel; `None` if a port can follow none of them.
fn inventory(events: &[Event]) -> Option<String> {
    #[derive(Default)]
    struct Has {
        notes: Option<(u8, u8)>,
        controllers: BTreeSet<u8>,
        bend: bool,
        pressure: bool,
        key_pressure: bool,
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
            MidiMessage::Aftertouch { .. } => has.key_pressure = true,
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
        parts.extend(has.key_pressure.then(|| "key pressure".to_owned()));
        if !parts.is_empty() {
            said.push(format!("{} on channel {channel}", list(&parts)));
        }
    }
    (!said.is_empty()).then(|| said.join(", "))
}

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
