//! The sound file a performance is kept in.
//!
//! Decides that what a disk took before it was full is kept: nobody plays the same twice.

use super::sink::{Sink, SinkStreams};
use ca_io::FileError;
use ca_io::sound::{WavOut, Written};

/// A WAV file. Sound that was lost is silence there, so that the rest stays where it belongs.
pub struct WavSink {
    /// none once it is full
    out: Option<WavOut>,
    channels: usize,
    /// tick of the next sample; none before the first
    next: Option<u64>,
}

impl WavSink {
    /// From tick 0 on.
    pub fn new(out: WavOut, channels: usize) -> WavSink {
        WavSink { out: Some(out), channels, next: Some(0) }
    }

    /// From the first sound that comes.
    pub fn from_now(out: WavOut, channels: usize) -> WavSink {
        WavSink { out: Some(out), channels, next: None }
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// If it cannot be written, or was ended before.
    pub fn finish(self) -> Result<Written, FileError> {
        self.out.map_or_else(|| Err(FileError::content("it was ended before")), WavOut::finish)
    }

    fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        let Some(out) = &mut self.out else { return Ok(()) };
        let Err(e) = out.write(frames) else { return Ok(()) };
        let kept = self.out.take().map(WavOut::finish_short);
        Err(match kept {
            Some(Ok(w)) => e.fix(format!("its first {:.1} s are kept", w.duration())),
            _ => e,
        })
    }
}

impl Sink for WavSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::WORDS }
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        let missing = self.next.map_or(0, |next| tick.saturating_sub(next));
        if missing > 0 {
            self.write(&vec![0.0; missing as usize * self.channels])?;
        }
        self.next = Some(tick + (frames.len() / self.channels) as u64);
        self.write(frames)
    }
}
