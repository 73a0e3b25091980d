//! A Standard MIDI File as one list of events with their times.
//!
//! Decides that tracks are merged by tick, and where ticks agree by the order of tracks, then of events: what a
//! sequencer plays. Tempo changes count wherever they stand, as sequencers have it, although format 1 keeps them in
//! the first track. Midly reads the bytes, event by event, because asked for a whole file it ends a track silently at
//! the first event it cannot read; here the bytes it leaves unread are an error with a place.

use crate::error::{FileError, FileErrorKind};
use midly::{Format, Fps, MetaMessage, MidiMessage, Timing, TrackEventKind};

/// One message, when and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Event {
    /// \[s\] from the beginning
    pub time: f64,
    /// 1 to 16
    pub channel: u8,
    pub message: MidiMessage,
}

enum Raw {
    Message(u8, MidiMessage),
    /// microseconds per beat
    Tempo(u32),
}

/// All channel messages of a file, in order of time.
pub(super) fn events(bytes: &[u8]) -> Result<Vec<Event>, FileError> {
    let (header, tracks) = midly::parse(bytes)
        .map_err(|e| FileError::format(format!("it is not a Standard MIDI File: {e}")).fix("export it again"))?;
    if header.format == Format::Sequential {
        let e = FileError::new(FileErrorKind::Unsupported, "it is of format 2, independent patterns");
        return Err(e.fix("export it as format 0 or 1"));
    }
    let announced = tracks.size_hint().0;
    whole(bytes, announced)?;
    let mut raw: Vec<(u64, Raw)> = Vec::new();
    let mut found = 0;
    for track in tracks {
        let track = track.map_err(|e| cut(format!("track {} cannot be read: {e}", found + 1)))?;
        found += 1;
        read_track(found, track, &mut raw)?;
    }
    if found < announced {
        return Err(cut(format!("{announced} tracks are announced, {found} are there")));
    }
    // stable: the order of tracks and events is kept within a tick
    raw.sort_by_key(|e| e.0);
    let mut clock = Clock::new(header.timing)?;
    let mut events = Vec::with_capacity(raw.len());
    for (tick, what) in raw {
        match what {
            Raw::Tempo(us) => clock.tempo(tick, us),
            Raw::Message(channel, message) => events.push(Event { time: clock.time(tick), channel, message }),
        }
    }
    Ok(events)
}

/// That the announced tracks are all there to their last byte: midly takes what there is of a chunk for all of it.
fn whole(bytes: &[u8], announced: usize) -> Result<(), FileError> {
    let (mut at, mut seen) = (0, 0);
    while let Some(head) = bytes.get(at..at + 8).filter(|_| seen < announced && bytes.starts_with(b"MThd")) {
        seen += usize::from(&head[..4] == b"MTrk");
        let size = u32::from_be_bytes([head[4], head[5], head[6], head[7]]) as usize;
        at = size.saturating_add(at + 8);
        if at > bytes.len() {
            return Err(cut(format!("track {seen} is {} bytes longer than the file", at - bytes.len())));
        }
    }
    Ok(())
}

fn cut(what: String) -> FileError {
    FileError::format(what).fix("the file is cut short or damaged; export it again")
}

fn read_track(n: usize, mut track: midly::EventIter<'_>, raw: &mut Vec<(u64, Raw)>) -> Result<(), FileError> {
    let length = track.unread().len();
    let mut tick = 0u64;
    for event in 1.. {
        let before = track.unread().len();
        let place = || format!("track {n}, event {event}, byte {} of the track", length - before);
        let Some(Ok(e)) = track.next() else {
            let what = if before > 0 { "it is no MIDI event" } else { "the track stops without an end" };
            return Err(cut(what.to_owned()).at(place()));
        };
        tick += u64::from(e.delta.as_int());
        match e.kind {
            TrackEventKind::Midi { channel, message } => {
                raw.push((tick, Raw::Message(channel.as_int() + 1, message)));
            }
            TrackEventKind::Meta(MetaMessage::Tempo(us)) if us.as_int() == 0 => {
                let e = FileError::content("a tempo of 0 µs per beat").at(place());
                return Err(e.fix("remove the event"));
            }
            TrackEventKind::Meta(MetaMessage::Tempo(us)) => raw.push((tick, Raw::Tempo(us.as_int()))),
            TrackEventKind::Meta(MetaMessage::EndOfTrack) => return Ok(()),
            _ => {}
        }
    }
    Ok(())
}

/// From ticks to seconds, in order of time.
///
/// Seconds are `(done + (tick − since) · step) / per_second`, all of it integers but the one division.
struct Clock {
    done: u128,
    since: u64,
    step: u32,
    per_second: f64,
    /// SMPTE time knows no tempo
    beats: bool,
}

impl Clock {
    fn new(timing: Timing) -> Result<Clock, FileError> {
        let (beats, step, per_second) = match timing {
            // 120 beats a minute until told otherwise
            Timing::Metrical(ppq) => (true, 500_000, f64::from(ppq.as_int()) * 1e6),
            // 29 means 30 / 1.001 frames a second
            Timing::Timecode(Fps::Fps29, sub) => (false, 1001, 30_000.0 * f64::from(sub)),
            Timing::Timecode(fps, sub) => (false, 1, f64::from(fps.as_int()) * f64::from(sub)),
        };
        if per_second == 0.0 {
            return Err(FileError::format("its header gives a beat or frame no ticks").fix("export it again"));
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
