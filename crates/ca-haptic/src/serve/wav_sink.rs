//! Writes the sound file of a performance. If the disk becomes full, the file retains what was written before, because
//! a performance cannot be repeated.

use super::sink::{Sink, SinkStreams};
use ca_io::FileError;
use ca_io::sound::{WavOut, Written};

/// A WAV file. It contains silence for lost sound, so that the rest stays at its time.
pub struct WavSink {
    /// `None` after a write error.
    out: Option<WavOut>,
    channels: usize,
    /// Tick of the next sample; `None` before the first.
    next: Option<u64>,
}

impl WavSink {
    /// Starts the file at tick 0.
    pub fn new(out: WavOut, channels: usize) -> WavSink {
        WavSink { out: Some(out), channels, next: Some(0) }
    }

    /// Starts the file at the first sound received.
    pub fn from_now(out: WavOut, channels: usize) -> WavSink {
        WavSink { out: Some(out), channels, next: None }
    }

    /// Finishes the file.
    ///
    /// # Errors
    /// If it cannot be written, or has ended before.
    pub fn finish(self) -> Result<Written, FileError> {
        self.out.map_or_else(|| Err(FileError::content("the file is already finished")), WavOut::finish)
    }

    fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        let Some(out) = &mut self.out else { return Ok(()) };
        let Err(e) = out.write(frames) else { return Ok(()) };
        let kept = self.out.take().map(WavOut::finish_short);
        Err(match kept {
            Some(Ok(w)) => e.fix(format!("the first {:.1} s are kept", w.duration())),
            _ => e,
        })
    }
}

impl Sink for WavSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::MESSAGES }
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
