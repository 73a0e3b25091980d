//! Sound out: FLAC files, which store 16 or 24 bits of each sample without loss, in about half the size of WAV.
//!
//! Each block is written when it is full, so memory does not grow with the length of the sound. The header contains the
//! number of samples and their hash, and is rewritten at the end. Samples are the same integers as in [`crate::sound`].

use crate::atomic_file::AtomicFile;
use crate::error::FileError;
use crate::format::Format;
use crate::sound::{Level, Written, integer};
use ca_core::internal::numeric::Plain;
use flac_codec::Error;
use flac_codec::encode::{FlacSampleWriter, Options};
use std::fs::File;
use std::io::{Cursor, Seek, Write};
use std::path::Path;

/// Largest number of channels.
pub const MAX_CHANNELS: usize = 8;
/// Highest rate \[Hz\].
pub const MAX_RATE: f64 = 655_350.0;

/// Returns the reason why a sound of this shape cannot be FLAC, if there is one.
pub fn refuses(channels: usize, rate: f64) -> Option<String> {
    let fits = (1..=MAX_CHANNELS).contains(&channels) && rate.fract() == 0.0 && (1.0..=MAX_RATE).contains(&rate);
    (!fits).then(|| {
        let most = Plain(MAX_RATE);
        format!(
            "FLAC supports 1 to {MAX_CHANNELS} channels at whole rates up to {most} Hz, not {channels} at {} Hz",
            Plain(rate)
        )
    })
}

/// Encodes a whole sound as the bytes of a file. Takes whole frames of interleaved samples within ±1.
///
/// # Errors
/// If the encoder refuses the sound.
pub fn encode(samples: &[f32], channels: usize, rate: f64, format: Format) -> Result<Vec<u8>, FileError> {
    if let Some(why) = refuses(channels, rate) {
        return Err(FileError::usage(why));
    }
    let failed = |e: Error| FileError::format(format!("the sound cannot be encoded: {e}"));
    let mut bytes = Vec::new();
    let mut encoder = encoder(Cursor::new(&mut bytes), rate, channels, format).map_err(failed)?;
    let full = full_scale(format);
    let samples: Vec<i32> = samples.iter().map(|x| integer(f64::from(*x), full)).collect();
    encoder.write(&samples).and_then(|()| encoder.finalize()).map_err(failed)?;
    Ok(bytes)
}

fn encoder<W: Write + Seek>(to: W, rate: f64, channels: usize, format: Format) -> Result<FlacSampleWriter<W>, Error> {
    let options = Options::default().no_padding().no_seektable();
    FlacSampleWriter::new(to, options, rate as u32, u32::from(format.bits()), channels as u8, None)
}

/// Returns the integer for a sample of 1.
fn full_scale(format: Format) -> f64 {
    f64::from(format.bits() - 1).exp2()
}

/// A FLAC file being written.
pub struct FlacOut {
    // before `staged`, so that it is closed before the hidden file is removed
    encoder: FlacSampleWriter<File>,
    staged: AtomicFile,
    full: f64,
    written: Written,
}

impl FlacOut {
    /// Begins the file over `staged`, which messages call `path`.
    ///
    /// # Errors
    /// If FLAC does not have this format, rate or number of channels, or the disk is full.
    pub fn over(
        staged: AtomicFile,
        path: &Path,
        rate: f64,
        channels: usize,
        format: Format,
    ) -> Result<FlacOut, FileError> {
        if format == Format::F32 {
            return Err(FileError::usage("FLAC does not support floats")
                .file(path.display())
                .fix("choose 24 or 16 bits"));
        }
        if let Some(why) = refuses(channels, rate) {
            return Err(FileError::usage(why)
                .file(path.display())
                .fix("write a `.wav` file, which supports more channels and rates"));
        }
        let encoder = encoder(staged.handle()?, rate, channels, format).map_err(|e| unwritten(path, e))?;
        let written = Written { path: path.to_owned(), frames: 0, rate: rate as u32, level: Level::new(channels) };
        Ok(FlacOut { encoder, staged, full: full_scale(format), written })
    }

    /// Appends whole frames of interleaved samples.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        let n = self.written.level.peak.len();
        if !frames.len().is_multiple_of(n) {
            let what = format!("{} samples are not whole frames of {n} channels", frames.len());
            return Err(FileError::usage(what).file(self.written.path.display()));
        }
        let (level, full) = (&mut self.written.level, self.full);
        let samples = frames.iter().zip((0..n).cycle()).map(|(x, channel)| integer(level.count(channel, *x), full));
        let samples: Vec<i32> = samples.collect();
        self.written.frames += (frames.len() / n) as u64;
        self.encoder.write(&samples).map_err(|e| unwritten(&self.written.path, e))
    }

    /// Returns the numbers of [`FlacOut::finish`], so far.
    pub fn so_far(&self) -> &Written {
        &self.written
    }

    /// Completes the file and puts it in its place.
    ///
    /// # Errors
    /// If the disk is full; the file is then removed.
    pub fn finish(self) -> Result<Written, FileError> {
        self.encoder.finalize().map_err(|e| unwritten(&self.written.path, e))?;
        self.staged.commit()?;
        Ok(self.written)
    }
}

fn unwritten(path: &Path, e: Error) -> FileError {
    match e {
        Error::Io(e) => FileError::io(path, "it cannot be written", &e),
        e => FileError::format(format!("it cannot be encoded: {e}")).file(path.display()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;

    /// Writing in pieces gives the same file as writing at once. `test_sweep_files.py` reads it with libsndfile.
    #[test]
    fn a_file_holds_the_samples_that_were_written() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.flac");
        for (format, channels, frames) in [(Format::I24, 2, 10_001), (Format::I16, 1, 4096), (Format::I16, 8, 5)] {
            let samples: Vec<f32> = (0..channels * frames)
                .map(|i| ((i / channels) as f32 * 0.01 * (i % channels + 1) as f32).sin())
                .collect();
            let staged = AtomicFile::create(&path).unwrap();
            let mut out = FlacOut::over(staged, &path, 44_100.0, channels, format).unwrap();
            let rows: Vec<f64> = samples.iter().map(|x| f64::from(*x)).collect();
            rows.chunks(channels * 777).for_each(|c| out.write(c).unwrap());
            let written = out.finish().unwrap();
            assert_eq!(written.frames, frames as u64);
            assert!(
                std::fs::read(&path).unwrap() == encode(&samples, channels, 44_100.0, format).unwrap(),
                "{format:?}"
            );
            let read = Recording::open(&path).unwrap();
            let full = full_scale(format);
            let of = |c: usize| -> Vec<f64> {
                let own = samples.iter().skip(c).step_by(channels);
                own.map(|x| f64::from(integer(f64::from(*x), full)) / full).collect()
            };
            let channels: Vec<Vec<f64>> = (0..channels).map(of).collect();
            assert_eq!(read, Recording { rate: 44_100.0, channels }, "{format:?}");
        }
    }

    #[test]
    fn what_flac_cannot_hold_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.flac");
        for (rate, channels, format, word) in [
            (48e3, 9, Format::I24, "1 to 8 channels"),
            (700e3, 1, Format::I24, "655350 Hz"),
            (44_100.5, 1, Format::I16, "whole rates"),
            (48e3, 1, Format::F32, "not support floats"),
        ] {
            let staged = AtomicFile::create(&path).unwrap();
            let refused = FlacOut::over(staged, &path, rate, channels, format).err().unwrap();
            assert!(refused.to_string().contains(word), "{refused}");
        }
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0);
    }
}
