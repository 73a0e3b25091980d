//! What a sink is: one trait for sound files, takes, terminals and Python, so that a new one is a file of its own.

use super::summary::StatsSnapshot;
use crate::record::Record;
use crate::version::Version;
use ca_io::FileError;
use std::fmt::Write as _;
use std::sync::Arc;

/// Where records end: a sound file, a take, a terminal.
pub trait Sink {
    /// What it is to be given, from the beginning to the end.
    fn streams(&self) -> SinkStreams {
        SinkStreams::ALL
    }
    /// Records, sound samples and pictures that it had to leave out so far.
    fn lost(&self) -> [u64; 3] {
        [0; 3]
    }
    /// What people should know of it by now: whether that is bad, and in words. Asked at each poll of the recorder.
    fn news(&mut self) -> Option<(bool, String)> {
        None
    }
    /// Something happened.
    ///
    /// # Errors
    /// Where it cannot be written any more; the sink is then left out.
    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        let _ = record;
        Ok(())
    }
    /// Sound, interleaved, the first of it at `tick`. It never comes before the records of what made it.
    ///
    /// # Errors
    /// Where it cannot be written any more; the sink is then left out.
    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        let _ = (tick, frames);
        Ok(())
    }
    /// A picture: displacement \[m\] of every place of the state, as it was before `tick`.
    ///
    /// # Errors
    /// Where it cannot be written any more; the sink is then left out.
    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        let _ = (tick, x);
        Ok(())
    }
    /// The motion in a picture: displacement \[m\] in a tick, of every place of the state. A sink on a thread of its own gets none.
    ///
    /// # Errors
    /// Where it cannot be written any more; the sink is then left out.
    fn motion(&mut self, tick: u64, d: &[f64]) -> Result<(), FileError> {
        let _ = (tick, d);
        Ok(())
    }
    /// From `tick` on another version of the scene plays, and pictures of then and later are of that.
    ///
    /// # Errors
    /// Where it cannot be written; the sink is then left out.
    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        let _ = (tick, version);
        Ok(())
    }
    /// Once a second.
    ///
    /// # Errors
    /// Where it cannot be written any more; the sink is then left out.
    fn snapshot(&mut self, snapshot: &StatsSnapshot) -> Result<(), FileError> {
        let _ = snapshot;
        Ok(())
    }
    /// Something people should know.
    ///
    /// # Errors
    /// Where it cannot be written any more; the sink is then left out.
    fn said(&mut self, notice: &Notice) -> Result<(), FileError> {
        let _ = notice;
        Ok(())
    }
}

/// What a sink is given; words it gets in any case.
#[allow(clippy::struct_excessive_bools, reason = "each is a stream of its own, wanted or not")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SinkStreams {
    /// what happened
    pub records: bool,
    /// sound
    pub sound: bool,
    /// pictures
    pub views: bool,
    /// statistics of the engine, once a second
    pub stats: bool,
}

impl SinkStreams {
    /// Everything.
    pub const ALL: SinkStreams = SinkStreams { records: true, sound: true, views: true, stats: true };
    /// Nothing but words.
    pub const WORDS: SinkStreams = SinkStreams { records: false, sound: false, views: false, stats: false };
}

/// Something people should know.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// sound sample
    pub tick: u64,
    /// the device it is about, if it is about one
    pub device: Option<String>,
    /// something went wrong
    pub bad: bool,
    /// in words
    pub text: String,
}

/// Records, sound samples and pictures that are missing, in words.
pub(super) fn missing(lost: [u64; 3]) -> String {
    let mut text = String::new();
    for (n, what) in lost.iter().zip(["records", "sound samples", "pictures"]).filter(|l| *l.0 > 0) {
        let _ = write!(text, "{}{n} {what}", if text.is_empty() { "" } else { ", " });
    }
    text
}
