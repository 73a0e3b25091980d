//! The sound file a performance is kept in.

use ca_haptic::serve::{Sink, SinkStreams};
use ca_io::FileError;
use ca_io::sound::{WavOut, Written};

/// A WAV file. Sound that was lost is silence there, so that the rest stays where it belongs.
pub(crate) struct Wav {
    out: WavOut,
    channels: usize,
    /// tick of the next sample; none before the first
    next: Option<u64>,
}

impl Wav {
    /// From tick 0 on.
    pub(super) fn new(out: WavOut, channels: usize) -> Wav {
        Wav { out, channels, next: Some(0) }
    }

    /// From the first sound that comes.
    pub(crate) fn from_now(out: WavOut, channels: usize) -> Wav {
        Wav { out, channels, next: None }
    }

    pub(crate) fn finish(self) -> Result<Written, FileError> {
        self.out.finish()
    }
}

impl Sink for Wav {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::WORDS }
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        let missing = self.next.map_or(0, |next| tick.saturating_sub(next));
        if missing > 0 {
            self.out.write(&vec![0.0; missing as usize * self.channels])?;
        }
        self.next = Some(tick + (frames.len() / self.channels) as u64);
        self.out.write(frames)
    }
}
