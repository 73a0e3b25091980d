//! The trait of all sinks: sound files, takes, terminals and Python. A new sink needs one new file.

use super::summary::StatsSnapshot;
use crate::record::Record;
use crate::version::Version;
use ca_io::FileError;
use std::fmt::Write as _;
use std::sync::Arc;

/// A receiver of records, e.g. a sound file, a take or a terminal.
pub trait Sink {
    /// Returns the streams that it receives, which never change.
    fn streams(&self) -> SinkStreams {
        SinkStreams::ALL
    }
    /// Returns the records, sound samples and pictures left out so far.
    fn lost(&self) -> [u64; 3] {
        [0; 3]
    }
    /// Returns a message about itself for people, if there is one: true for a problem, and the text. Called at each
    /// poll of the recorder.
    fn poll_notice(&mut self) -> Option<(bool, String)> {
        None
    }
    /// Receives a record.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        let _ = record;
        Ok(())
    }
    /// Receives interleaved sound, with the first sample at `tick`. The records of what made it always come earlier.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        let _ = (tick, frames);
        Ok(())
    }
    /// Receives a picture: displacement \[m\] of each place of the state, as it was before `tick`.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        let _ = (tick, x);
        Ok(())
    }
    /// Receives the motion in a picture: displacement \[m\] per tick, of each place of the state. A sink in an
    /// `AsyncSink` does not receive it.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn motion(&mut self, tick: u64, d: &[f64]) -> Result<(), FileError> {
        let _ = (tick, d);
        Ok(())
    }
    /// Receives the version of the scene that plays from `tick` on, and to which pictures belong from then on.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        let _ = (tick, version);
        Ok(())
    }
    /// Receives statistics, once a second.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn snapshot(&mut self, snapshot: &StatsSnapshot) -> Result<(), FileError> {
        let _ = snapshot;
        Ok(())
    }
    /// Receives a message for people.
    ///
    /// # Errors
    /// If it cannot be written any more; the recorder then drops the sink.
    fn notice(&mut self, notice: &Notice) -> Result<(), FileError> {
        let _ = notice;
        Ok(())
    }
}

/// Streams that a sink receives. Each sink receives messages.
#[allow(clippy::struct_excessive_bools, reason = "each is a stream of its own, wanted or not")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SinkStreams {
    /// Records.
    pub records: bool,
    /// Sound.
    pub sound: bool,
    /// Pictures.
    pub views: bool,
    /// Statistics of the engine, once a second.
    pub stats: bool,
}

impl SinkStreams {
    /// All streams.
    pub const ALL: SinkStreams = SinkStreams { records: true, sound: true, views: true, stats: true };
    /// Messages only.
    pub const MESSAGES: SinkStreams = SinkStreams { records: false, sound: false, views: false, stats: false };
}

/// A message for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// Sound sample.
    pub tick: u64,
    /// Name of the device concerned, if any.
    pub device: Option<String>,
    /// True for a problem.
    pub bad: bool,
    /// Text.
    pub text: String,
}

/// Describes the number of missing records, sound samples and pictures.
pub(super) fn missing(lost: [u64; 3]) -> String {
    let mut text = String::new();
    for (n, what) in lost.iter().zip(["records", "sound samples", "pictures"]).filter(|l| *l.0 > 0) {
        let _ = write!(text, "{}{n} {what}", if text.is_empty() { "" } else { ", " });
    }
    text
}
