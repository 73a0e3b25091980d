//! Reads a Standard MIDI File as one list of events with times.
//!
//! Tracks are merged by tick; at equal ticks by the order of tracks, then of events, as in sequencers. Tempo changes
//! apply in every track, as in sequencers, although format 1 has them only in the first.
//!
//! Events are read from midly one by one. When asked for a whole track, midly silently ends it at the first event that
//! it cannot read; here the unread bytes are an error with a place. This module reads the chunks and the header,
//! because midly accepts a truncated chunk as whole, and overflows on one kind of frame rate.
//!
//! Some violations of the standard are accepted with a remark, as players accept them: running status that continues
//! after a meta or system-exclusive event, and a wrong number of tracks in the header. A file may also be wrapped in
//! RIFF (RMID, `.rmi`).

use crate::error::{FileError, FileErrorKind};
use midly::{EventIter, MetaMessage, MidiMessage, TrackEventKind};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    /// Time from the beginning \[s\].
    pub time: f64,
    /// Channel, 1 to 16.
    pub channel: u8,
    pub message: MidiMessage,
}

enum Raw {
    Message(u8, MidiMessage),
    /// Microseconds per beat.
    Tempo(u32),
}

pub(super) struct Messages {
    /// All channel messages, in order of time.
    pub events: Vec<Event>,
    /// Violations of the standard, in words.
    pub remarks: Vec<String>,
}

pub(super) fn messages(bytes: &[u8]) -> Result<Messages, FileError> {
    let not_one = || FileError::format("it is not a Standard MIDI File").fix("export it as one, format 0 or 1");
    let bytes = unwrapped(bytes).ok_or_else(not_one)?;
    let [b'M', b'T', b'h', b'd', 0, 0, 0, size, 0, format, n1, n0, t1, t0, ..] = *bytes else {
        return Err(not_one());
    };
    let mut rest = bytes.get(8 + usize::from(size.max(6))..).ok_or_else(not_one)?;
    if format > 1 {
        let e = FileError::new(
            FileErrorKind::Unsupported,
            format!("it has format {format}, independent patterns, which is not supported"),
        );
        return Err(e.fix("export it as format 0 or 1"));
    }
    let mut clock = Clock::new([t1, t0])?;
    let announced = u16::from_be_bytes([n1, n0]);
    let mut raw: Vec<(u64, Raw)> = Vec::new();
    let announced = u32::from(announced);
    let (mut found, mut broken) = (0, 0);
    while let Some((head, after)) = rest.split_at_checked(8) {
        let is_track = head.starts_with(b"MTrk");
        // anything may follow the last track
        if found >= announced && !is_track {
            break;
        }
        let size = u32::from_be_bytes([head[4], head[5], head[6], head[7]]) as usize;
        let Some((body, after)) = after.split_at_checked(size) else {
            return Err(cut(format!("track {} is {} bytes longer than the file", found + 1, size - after.len())));
        };
        rest = after;
        // chunks of other types may come between
        if is_track {
            found += 1;
            broken += read_track(found, EventIter::new(body), &mut raw)?;
        }
    }
    // whole tracks may be missing, but not part of one
    if found == 0 || found < announced && !rest.is_empty() {
        return Err(cut(format!("{announced} tracks are announced, but it has {found}")));
    }
    let mut remarks = Vec::new();
    if found < announced {
        remarks.push(format!("its header announces {announced} tracks, but it has {found}; the file may be cut short"));
    }
    if found > announced {
        remarks.push(format!("its header announces {announced} of its {found} tracks; all are read"));
    }
    if broken > 0 {
        let rule = "after a meta or system-exclusive event, which the standard forbids";
        let times = if broken == 1 { "once".into() } else { format!("{broken} times") };
        remarks.push(format!("running status continues {times} {rule}; the status from before that event is used"));
    }
    // stable, so tracks and events keep their order within a tick
    raw.sort_by_key(|e| e.0);
    let mut events = Vec::with_capacity(raw.len());
    for (tick, what) in raw {
        match what {
            Raw::Tempo(us) => clock.tempo(tick, us),
            Raw::Message(channel, message) => events.push(Event { time: clock.time(tick), channel, message }),
        }
    }
    Ok(Messages { events, remarks })
}

/// Returns the file inside a RIFF container of the form RMID, or the bytes themselves; `None` if the container has no
/// file.
fn unwrapped(bytes: &[u8]) -> Option<&[u8]> {
    let Some(riff) = bytes.strip_prefix(b"RIFF") else { return Some(bytes) };
    let mut rest = riff.get(4..)?.strip_prefix(b"RMID")?;
    loop {
        let (head, body) = rest.split_at_checked(8)?;
        let size = u32::from_le_bytes([head[4], head[5], head[6], head[7]]) as usize;
        if head.starts_with(b"data") {
            // a truncated container gives the error of a truncated track
            return Some(&body[..size.min(body.len())]);
        }
        rest = body.get(size.checked_add(size % 2)?..)?;
    }
}

fn cut(what: String) -> FileError {
    FileError::format(what).fix("the file is cut short or damaged; export it again")
}

/// Reads a track, and returns how often running status continues after a meta or system-exclusive event.
fn read_track(n: u32, mut track: EventIter<'_>, raw: &mut Vec<(u64, Raw)>) -> Result<u32, FileError> {
    let length = track.unread().len();
    let mut tick = 0u64;
    let (mut status, mut broken) = (None, 0);
    for event in 1.. {
        let before = track.unread().len();
        // midly resets the running status at a meta or system-exclusive event
        status = track.running_status().or(status);
        if track.running_status() != status && lacks_status(track.unread()) {
            *track.running_status_mut() = status;
            broken += 1;
        }
        let place = || format!("track {n}, event {event}, byte {} of the track", length - before);
        let Some(Ok(e)) = track.next() else {
            let what = if before > 0 { "the bytes are not a MIDI event" } else { "the track lacks its end event" };
            return Err(cut(what.to_owned()).at(place()));
        };
        tick += u64::from(e.delta.as_int());
        match e.kind {
            TrackEventKind::Midi { channel, message } => {
                raw.push((tick, Raw::Message(channel.as_int() + 1, message)));
            }
            TrackEventKind::Meta(MetaMessage::Tempo(us)) if us.as_int() == 0 => {
                let e = FileError::content("the tempo is 0 µs per beat").at(place());
                return Err(e.fix("remove the event"));
            }
            TrackEventKind::Meta(MetaMessage::Tempo(us)) => raw.push((tick, Raw::Tempo(us.as_int()))),
            TrackEventKind::Meta(MetaMessage::EndOfTrack) => return Ok(broken),
            _ => {}
        }
    }
    Ok(broken)
}

/// Returns true if the next event begins with data: no status byte follows its delta time.
fn lacks_status(unread: &[u8]) -> bool {
    let delta = unread.iter().take_while(|b| **b >= 0x80).count();
    unread.get(delta + 1).is_some_and(|b| *b < 0x80)
}

/// Converts ticks to seconds, in order of time.
///
/// Seconds are `(done + (tick − since) · step) / per_second`, with integers for all but the division.
struct Clock {
    done: u128,
    since: u64,
    step: u32,
    per_second: f64,
    /// False for SMPTE time, which has no tempo.
    beats: bool,
}

impl Clock {
    /// Takes the last two bytes of the header.
    fn new(time: [u8; 2]) -> Result<Clock, FileError> {
        let sub = f64::from(time[1]);
        let (beats, step, per_second) = match time[0] {
            // 120 beats a minute until the first tempo event
            0..0x80 => (true, 500_000, f64::from(u16::from_be_bytes(time)) * 1e6),
            // frames a second, negated; 29 means 30 / 1.001
            frames => match frames.wrapping_neg() {
                29 => (false, 1001, 30_000.0 * sub),
                fps @ (24 | 25 | 30) => (false, 1, f64::from(fps) * sub),
                fps => {
                    let e = FileError::new(
                        FileErrorKind::Unsupported,
                        format!("its time code has {fps} frames per second"),
                    );
                    return Err(e.fix("export it with 24, 25, 29 or 30 frames per second, or in beats"));
                }
            },
        };
        if per_second == 0.0 {
            return Err(FileError::format("its header sets 0 ticks per beat or frame").fix("export it again"));
        }
        Ok(Clock { done: 0, since: 0, step, per_second, beats })
    }

    fn passed(&self, tick: u64) -> u128 {
        self.done + u128::from(tick - self.since) * u128::from(self.step)
    }

    fn time(&self, tick: u64) -> f64 {
        self.passed(tick) as f64 / self.per_second
    }

    fn tempo(&mut self, tick: u64, us: u32) {
        if self.beats {
            self.done = self.passed(tick);
            self.since = tick;
            self.step = us;
        }
    }
}
