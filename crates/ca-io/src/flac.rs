//! Sound out: FLAC, which keeps 16 or 24 bits of each sample without loss, in about half the room of WAV.
//!
//! Each block goes to the file when it is full, so an hour of sound takes no more memory than a second. The head has the number of
//! samples and their hash, and is written again at the end. Samples are the integers of [`crate::sound`].

use crate::atomic_file::AtomicFile;
use crate::error::FileError;
use crate::sound::{Format, Level, Written, integer};
use ca_model::quantity::Plain;
use flacenc::bitsink::ByteSink;
use flacenc::component::{BitRepr, Stream, StreamInfo};
use flacenc::config;
use flacenc::encode_fixed_size_frame;
use flacenc::error::{Verified, Verify as _};
use flacenc::source::{Context, Fill as _, FrameBuf};
use std::fs::File;
use std::io::{Seek as _, Write as _};
use std::path::Path;

/// Most channels.
pub const MAX_CHANNELS: usize = 8;
/// Fastest rate \[Hz\].
pub const MAX_RATE: f64 = 655_350.0;

/// Why a sound of this shape cannot be FLAC.
pub fn refuses(channels: usize, rate: f64) -> Option<String> {
    let fits = (1..=MAX_CHANNELS).contains(&channels) && rate.fract() == 0.0 && (1.0..=MAX_RATE).contains(&rate);
    (!fits).then(|| {
        let most = Plain(MAX_RATE);
        format!(
            "FLAC holds 1 to {MAX_CHANNELS} channels at whole rates up to {most} Hz, not {channels} at {}",
            Plain(rate)
        )
    })
}

/// A whole sound as the bytes of a file. Interleaved samples within ±1, whole frames.
///
/// # Errors
/// If the encoder refuses it.
pub fn encode(samples: &[f32], channels: usize, rate: f64, format: Format) -> Result<Vec<u8>, FileError> {
    let mut encoder = Encoder::new(rate, channels, format)?;
    let full = f64::from(format.bits() - 1).exp2();
    let samples: Vec<i32> = samples.iter().map(|x| integer(f64::from(*x), full)).collect();
    let mut frames = Vec::new();
    for block in samples.chunks(encoder.block()) {
        frames.extend(encoder.frame(block)?);
    }
    let mut all = encoder.head()?;
    all.extend(frames);
    Ok(all)
}

fn failed(e: impl std::fmt::Debug) -> FileError {
    FileError::format(format!("a sound cannot be encoded: {e:?}"))
}

fn bits(of: &impl BitRepr) -> Result<Vec<u8>, FileError> {
    let mut sink = ByteSink::new();
    of.write(&mut sink).map_err(|e| failed(e.to_string()))?;
    Ok(sink.as_slice().to_vec())
}

/// Blocks of samples to frames.
struct Encoder {
    config: Verified<config::Encoder>,
    info: StreamInfo,
    block: FrameBuf,
    heard: Context,
}

impl Encoder {
    fn new(rate: f64, channels: usize, format: Format) -> Result<Encoder, FileError> {
        if let Some(why) = refuses(channels, rate) {
            return Err(FileError::usage(why));
        }
        let bits = usize::from(format.bits());
        let config = config::Encoder::default().into_verified().map_err(|e| failed(e.1))?;
        let mut info = StreamInfo::new(rate as usize, channels, bits).map_err(failed)?;
        info.set_block_sizes(config.block_size, config.block_size).map_err(failed)?;
        let block = FrameBuf::with_size(channels, config.block_size).map_err(failed)?;
        Ok(Encoder { config, info, block, heard: Context::new(bits, channels) })
    }

    /// Samples of a block, of all channels.
    fn block(&self) -> usize {
        self.config.block_size * self.info.channels()
    }

    /// The bytes of the next block. Only the last one may be shorter than [`Encoder::block`].
    fn frame(&mut self, samples: &[i32]) -> Result<Vec<u8>, FileError> {
        self.block.fill_interleaved(samples).map_err(failed)?;
        self.heard.fill_interleaved(samples).map_err(failed)?;
        let number = self.heard.current_frame_number().unwrap_or(0);
        let frame = encode_fixed_size_frame(&self.config, &self.block, number, &self.info).map_err(failed)?;
        self.info.update_frame_info(&frame);
        bits(&frame)
    }

    /// The head of a file with the frames so far.
    fn head(&self) -> Result<Vec<u8>, FileError> {
        let mut info = self.info.clone();
        info.set_md5_digest(&self.heard.md5_digest());
        info.set_total_samples(self.heard.total_samples());
        info.set_block_sizes(self.config.block_size, self.config.block_size).map_err(failed)?;
        bits(&Stream::with_stream_info(info))
    }
}

/// A FLAC file under way.
pub struct FlacOut {
    // before `staged`, so that it is closed when the sibling is removed
    file: File,
    staged: AtomicFile,
    encoder: Encoder,
    /// samples of a block that is not full
    waiting: Vec<i32>,
    /// what full scale is
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
            return Err(FileError::usage("FLAC holds no floats").file(path.display()).fix("choose 24 or 16 bits"));
        }
        let encoder = Encoder::new(rate, channels, format)
            .map_err(|e| e.file(path.display()).fix("a WAV file holds more channels and rates"))?;
        let written = Written { path: path.to_owned(), frames: 0, rate: rate as u32, level: Level::new(channels) };
        let full = f64::from(format.bits() - 1).exp2();
        let mut out = FlacOut { file: staged.handle()?, staged, encoder, waiting: Vec::new(), full, written };
        let head = out.encoder.head()?;
        out.put(&head)?;
        Ok(out)
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
        for (x, channel) in frames.iter().zip((0..n).cycle()) {
            self.waiting.push(integer(self.written.level.keep(channel, *x), self.full));
        }
        self.written.frames += (frames.len() / n) as u64;
        let block = self.encoder.block();
        let whole = self.waiting.len() - self.waiting.len() % block;
        let waiting = std::mem::take(&mut self.waiting);
        let (now, later) = waiting.split_at(whole);
        self.waiting = later.to_vec();
        for samples in now.chunks_exact(block) {
            let bytes = self.encoder.frame(samples)?;
            self.put(&bytes)?;
        }
        Ok(())
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        self.file.write_all(bytes).map_err(|e| FileError::io(&self.written.path, "it cannot be written", &e))
    }

    /// The numbers of [`FlacOut::finish`], so far.
    pub fn so_far(&self) -> &Written {
        &self.written
    }

    /// Completes the file and puts it in its place.
    ///
    /// # Errors
    /// If the disk is full; the file is then removed.
    pub fn finish(mut self) -> Result<Written, FileError> {
        let last = std::mem::take(&mut self.waiting);
        if !last.is_empty() {
            let bytes = self.encoder.frame(&last)?;
            self.put(&bytes)?;
        }
        let head = self.encoder.head()?;
        self.file.rewind().map_err(|e| FileError::io(&self.written.path, "it cannot be written", &e))?;
        self.put(&head)?;
        self.staged.commit()?;
        Ok(self.written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Block by block, in pieces of any length, is the same as all at once by the library, whose sounds other decoders read.
    #[test]
    fn blocks_are_the_bytes_of_the_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.flac");
        for (format, channels, frames) in [(Format::I24, 2, 10_001), (Format::I16, 1, 4096), (Format::I16, 8, 5)] {
            let samples: Vec<f32> = (0..channels * frames)
                .map(|i| ((i / channels) as f32 * 0.01 * (i % channels + 1) as f32).sin())
                .collect();
            let full = f64::from(format.bits() - 1).exp2();
            let whole: Vec<i32> = samples.iter().map(|x| integer(f64::from(*x), full)).collect();
            let config = config::Encoder::default().into_verified().unwrap();
            let source = flacenc::source::MemSource::from_samples(&whole, channels, usize::from(format.bits()), 44_100);
            let stream = flacenc::encode_with_fixed_block_size(&config, source, config.block_size).unwrap();
            let expected = bits(&stream).unwrap();

            let staged = AtomicFile::create(&path).unwrap();
            let mut out = FlacOut::over(staged, &path, 44_100.0, channels, format).unwrap();
            let rows: Vec<f64> = samples.iter().map(|x| f64::from(*x)).collect();
            rows.chunks(channels * 777).for_each(|c| out.write(c).unwrap());
            let written = out.finish().unwrap();
            assert_eq!(written.frames, frames as u64);
            assert!(std::fs::read(&path).unwrap() == expected, "{format:?}");
            assert!(encode(&samples, channels, 44_100.0, format).unwrap() == expected, "{format:?}");
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
            (48e3, 1, Format::F32, "no floats"),
        ] {
            let staged = AtomicFile::create(&path).unwrap();
            let refused = FlacOut::over(staged, &path, rate, channels, format).err().unwrap();
            assert!(refused.to_string().contains(word), "{refused}");
        }
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 0);
    }
}
