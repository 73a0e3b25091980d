//! Describes the ports of a model: the rest position of each, and the MIDI messages that move it.
//!
//! Instances that differ only in their notes share a line, named by a selector, `key[0..12].key`, instead of 24 lines.

use ca_core::internal::io::midi::{MidiMap, MidiSource};
use ca_core::{Input, InputRole, Scene, Unit};
use ca_model::quantity::{note_name, show};

/// Notes that are listed one by one.
const LISTED: usize = 8;
/// Maximum number of lines; the last names the remaining ports.
const LINES: usize = 8;

/// Ports that differ only in index and notes.
struct Row<'s> {
    /// Name before the index, index, name after the index.
    name: (&'s str, Option<usize>, &'s str),
    ports: Vec<&'s Input>,
}

/// Splits a name at the first index of instances.
fn parted(name: &str) -> (&str, Option<usize>, &str) {
    let found = name.split_once('[').and_then(|(head, rest)| {
        let (index, tail) = rest.split_once(']')?;
        Some((head, Some(index.parse().ok()?), tail))
    });
    found.unwrap_or((name, None, ""))
}

/// Returns a mapping without its notes.
fn way(map: &MidiMap) -> MidiMap {
    match map.source {
        MidiSource::Note { .. } => MidiMap { source: MidiSource::Note { low: 0, high: 127 }, ..*map },
        _ => *map,
    }
}

fn rows(scene: &Scene) -> Vec<Row<'_>> {
    let mut rows: Vec<Row<'_>> = Vec::new();
    for port in &scene.inputs {
        let name = parted(&port.name);
        let next = |row: &&mut Row<'_>| {
            let (head, index, tail) = row.name;
            let first = row.ports[0];
            index.is_some_and(|i| name == (head, Some(i + row.ports.len()), tail))
                && (first.rest, first.role) == (port.rest, port.role)
                && first.midi.as_ref().map(way) == port.midi.as_ref().map(way)
        };
        match rows.iter_mut().find(next) {
            Some(row) => row.ports.push(port),
            None => rows.push(Row { name, ports: vec![port] }),
        }
    }
    rows
}

/// Describes each port, or group of similar ports, in one line; a last line names the rest.
pub fn lines(scene: &Scene) -> Vec<String> {
    let rows = rows(scene);
    let listed = if rows.len() > LINES { LINES - 1 } else { rows.len() };
    let mut lines: Vec<String> = rows.iter().take(listed).map(line).collect();
    if rows.len() > listed {
        let names: Vec<String> = rows.iter().skip(listed).map(name).collect();
        lines.push(format!("and {}", names.join(", ")));
    }
    lines
}

fn name(row: &Row<'_>) -> String {
    match (row.name, row.ports.len()) {
        ((head, Some(i), tail), n) if n > 1 => format!("{head}[{i}..{}]{tail}", i + n),
        _ => row.ports[0].name.clone(),
    }
}

fn line(row: &Row<'_>) -> String {
    let port = row.ports[0];
    let unit = if port.role == InputRole::Force { Unit::NEWTON } else { Unit::METRE };
    let midi = port.midi.as_ref().map_or(String::new(), |m| {
        let by = match m.source {
            MidiSource::Note { .. } => notes(row.ports.iter().copied()).unwrap_or_default(),
            MidiSource::Control(n) => format!("controller {n}"),
            MidiSource::PitchBend => "pitch bend".into(),
            MidiSource::Pressure => "channel pressure".into(),
        };
        format!("; MIDI {} to {}, {by}", show(m.from, unit), show(m.to, unit))
    });
    format!("{}  rests at {}{midi}", name(row), show(port.rest, unit))
}

/// Describes the notes that move any of these ports; `None` without notes.
pub fn notes<'s>(ports: impl Iterator<Item = &'s Input>) -> Option<String> {
    let mut all: Vec<u8> = Vec::new();
    for m in ports.filter_map(|p| p.midi.as_ref()) {
        if let MidiSource::Note { low, high } = m.source {
            all.extend(low..=high);
        }
    }
    all.sort_unstable();
    all.dedup();
    let (low, high) = (*all.first()?, *all.last()?);
    let without_gap = usize::from(high - low) + 1 == all.len();
    Some(match all.len() {
        1 => format!("note {}", note_name(low)),
        n if without_gap && n > 2 => format!("notes {} to {}", note_name(low), note_name(high)),
        n if n <= LISTED => {
            let names: Vec<String> = all.iter().map(|n| note_name(*n)).collect();
            format!("notes {}", names.join(", "))
        }
        n => format!("{n} notes from {} to {}", note_name(low), note_name(high)),
    })
}
