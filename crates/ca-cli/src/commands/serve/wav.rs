//! The sound file a performance is kept in.

use ca_haptic::serve::{Sink, SinkStreams};
use ca_io::FileError;
use ca_io::sound::{WavOut, Written};

/// A WAV file. Sound that was lost is silence there, so that the rest stays where it belongs.
pub(super) struct Wav {
    out: WavOut,
    channels: usize,
    next: u64,
}

impl Wav {
    pub(super) fn new(out: WavOut, channels: usize) -> Wav {
        Wav { out, channels, next: 0 }
    }

    pub(super) fn finish(self) -> Result<Written, FileError> {
        self.out.finish()
    }
}

impl Sink for Wav {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::WORDS }
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        if tick > self.next {
            self.out.write(&vec![0.0; (tick - self.next) as usize * self.channels])?;
        }
        self.next = tick + (frames.len() / self.channels) as u64;
        self.out.write(frames)
    }
}
