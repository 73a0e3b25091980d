//! Distributes the outputs of a render to its files, the sound and the probes, and measures the sound on the way.

use crate::error::FileError;
use crate::level_and_fade::{Ended, RenderOut};
use crate::low_frequency::LowFrequencyMeter;
use crate::probe::ProbeOut;

/// Files of a render being written.
pub struct Files {
    wav: RenderOut,
    slow: LowFrequencyMeter,
    /// Probe files, each with its number of columns.
    probes: Vec<(ProbeOut, usize)>,
    channels: usize,
    /// Samples waiting to be written: the sound, then one list for each probe.
    waiting: Vec<Vec<f64>>,
}

impl Files {
    /// Takes a sound file with `channels` channels at `rate` \[Hz\], and probe files, each with its number of columns.
    pub fn new(wav: RenderOut, probes: Vec<(ProbeOut, usize)>, channels: usize, rate: f64) -> Files {
        let waiting = vec![Vec::new(); 1 + probes.len()];
        Files { wav, slow: LowFrequencyMeter::new(channels, rate), probes, channels, waiting }
    }

    /// Appends rows of all outputs: the channels, then the columns of each probe.
    ///
    /// # Errors
    /// If a file cannot be written, as [`RenderOut::write`] and [`ProbeOut::write`].
    pub fn write(&mut self, rows: &[f64]) -> Result<(), FileError> {
        if self.probes.is_empty() {
            self.slow.add(rows);
            return self.wav.write(rows);
        }
        let columns: usize = self.probes.iter().map(|p| p.1).sum();
        self.waiting.iter_mut().for_each(Vec::clear);
        for row in rows.chunks_exact((self.channels + columns).max(1)) {
            let mut rest = row;
            let widths = [self.channels].into_iter().chain(self.probes.iter().map(|p| p.1));
            for (list, n) in self.waiting.iter_mut().zip(widths) {
                let (own, others) = rest.split_at(n);
                list.extend_from_slice(own);
                rest = others;
            }
        }
        self.slow.add(&self.waiting[0]);
        self.wav.write(&self.waiting[0])?;
        for ((file, _), values) in self.probes.iter_mut().zip(&self.waiting[1..]) {
            file.write(values)?;
        }
        Ok(())
    }

    /// Completes all files.
    ///
    /// # Errors
    /// As [`RenderOut::finish`] and [`ProbeOut::finish`].
    pub fn finish(self, diverged: bool) -> Result<(Ended, LowFrequencyMeter), FileError> {
        let ended = self.wav.finish(diverged)?;
        for (file, _) in self.probes {
            file.finish()?;
        }
        Ok((ended, self.slow))
    }
}
