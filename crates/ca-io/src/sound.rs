//! Sound out: WAV files of renders.
//!
//! Samples are clipped at ±1, integers always and floats unless the file is [`WavOut::unlimited`]. Every clipped sample
//! is counted, and the peak *before* clipping shows the right gain. A sample without a value (NaN, infinite) becomes
//! silence and is counted separately: clipping means too loud, NaN means a broken model.
//!
//! Integers are `round(x · 2ⁿ⁻¹)`, ties to even, at most 2ⁿ⁻¹ − 1. This is the inverse of reading gestures: −1 and all
//! dyadic values return to the bit, and +1 is one step short. There is no dither: the same model gives the same bytes,
//! and all noise in a render comes from the model. The price is distortion in 16 bits where sound fades below −90 dB;
//! 24 bits avoid it at one and a half times the size.
//!
//! `wav_header.rs` writes the header, because hound knows no `RF64`, `fact` or pad byte. Samples are written as bytes,
//! because hound's writer took longer per sample than computing a short string.
//!
//! The file is put in place only when it is finished (`atomic_file.rs`). Beyond two channels the header assigns no
//! loudspeakers: outputs of a model are not left, right, centre and subwoofer, and players that mix down would drop the
//! fourth channel.

use crate::atomic_file::AtomicFile;
use crate::error::FileError;
use crate::format::Format;
use crate::wav_header;
use ca_core::internal::numeric::Plain;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Largest number of channels in a file.
pub const MAX_CHANNELS: usize = 256;

/// Bytes written to the file at a time.
const ROOM: usize = 1 << 16;

/// Result of writing a sound.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// File, as the caller named it.
    pub path: PathBuf,
    /// Samples per channel.
    pub frames: u64,
    /// Sample rate \[Hz\].
    pub rate: u32,
    /// Level before clipping.
    pub level: Level,
}

impl Written {
    /// Returns the length \[s\].
    pub fn duration(&self) -> f64 {
        self.frames as f64 / f64::from(self.rate)
    }
    /// Returns true if no sample was clipped or without a value.
    pub fn is_faithful(&self) -> bool {
        self.level.clipped == 0 && self.level.non_finite == 0
    }
}

/// Level of a sound before clipping.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Level {
    /// Greatest |sample| of each channel before clipping, 1 = full scale.
    pub peak: Vec<f64>,
    /// Number of samples clipped at ±1.
    pub clipped: u64,
    /// Number of samples beyond ±1 that were kept.
    pub beyond: u64,
    /// Number of samples without a value, which became 0.
    pub non_finite: u64,
}

impl Level {
    /// Takes the number of channels.
    pub fn new(channels: usize) -> Level {
        Level { peak: vec![0.0; channels], ..Level::default() }
    }

    /// Counts a sample of a channel and returns it clipped at full scale.
    #[inline]
    pub fn count(&mut self, channel: usize, x: f64) -> f64 {
        if !x.is_finite() {
            self.non_finite += 1;
            return 0.0;
        }
        self.peak[channel] = self.peak[channel].max(x.abs());
        self.clipped += u64::from(x.abs() > 1.0);
        x.clamp(-1.0, 1.0)
    }

    /// Applies [`Level::count`] to the first numbers of each row of `width` numbers, one for each channel, and writes
    /// them to `sound`.
    pub fn keep_rows<S: Sample>(&mut self, rows: &[f64], width: usize, sound: &mut [S]) {
        let channels = self.peak.len();
        if channels == 0 {
            return;
        }
        let fits = self.all_within(rows, width);
        for (row, to) in rows.chunks_exact(width).zip(sound.chunks_exact_mut(channels)) {
            for (k, (to, x)) in to.iter_mut().zip(row).enumerate() {
                *to = S::of(if fits { *x } else { self.count(k, *x) });
            }
        }
    }

    /// Returns true if all samples are finite and within full scale, which is nearly always so, and then enters their
    /// peaks. One loop of comparisons is cheaper than [`Level::count`] for each sample.
    fn all_within(&mut self, rows: &[f64], width: usize) -> bool {
        let within = |most: f64, x: &f64| if x.abs() <= most { most } else { x.abs() };
        let channels = self.peak.len();
        // also false for NaN
        let fits = if channels == width {
            rows.iter().fold(true, |all, x| all & (x.abs() <= 1.0))
        } else {
            rows.chunks_exact(width).flat_map(|row| &row[..channels]).fold(true, |all, x| all & (x.abs() <= 1.0))
        };
        if fits {
            for (k, peak) in self.peak.iter_mut().enumerate() {
                *peak = rows.iter().skip(k).step_by(width).fold(*peak, within);
            }
        }
        fits
    }

    /// As [`Level::count`], but values beyond full scale are kept, within the range of 32-bit floats.
    #[inline]
    fn pass(&mut self, channel: usize, x: f64) -> f64 {
        if !x.is_finite() {
            self.non_finite += 1;
            return 0.0;
        }
        self.peak[channel] = self.peak[channel].max(x.abs());
        self.beyond += u64::from(x.abs() > 1.0);
        x.clamp(f64::from(f32::MIN), f64::from(f32::MAX))
    }
}

/// Number type in which samples are stored.
pub trait Sample: Copy + Default + Send {
    /// Converts a value.
    fn of(value: f64) -> Self;
}

impl Sample for f32 {
    fn of(value: f64) -> f32 {
        value as f32
    }
}

impl Sample for f64 {
    fn of(value: f64) -> f64 {
        value
    }
}

/// Returns a WAV file in memory, with the bytes that [`WavOut::unlimited`] writes.
///
/// # Errors
/// As [`WavOut::create`] and [`WavOut::write`]; messages call the file `name`.
pub fn wav_bytes(name: &str, rate: f64, channels: usize, frames: &[f64]) -> Result<Vec<u8>, FileError> {
    let path = Path::new(name);
    shape(path, rate, channels)?;
    let mut level = Level::new(channels);
    whole(path, frames.len(), channels)?;
    let mut bytes = wav_header::open(Format::F32, rate as u32, channels as u16);
    let (head, data) = (bytes.len(), frames.len() * 4);
    wav_header::close(&mut bytes, Format::F32, (frames.len() / channels) as u64, data as u64);
    bytes.resize(head + data, 0);
    each(frames, &mut level, &mut bytes[head..], Level::pass, |x| (x as f32).to_le_bytes());
    Ok(bytes)
}

/// Refuses a rate \[Hz\] or a number of channels that a WAV file cannot have.
fn shape(path: &Path, rate: f64, channels: usize) -> Result<(), FileError> {
    if !(1.0..=1e6).contains(&rate) || rate.fract() != 0.0 {
        let e = FileError::usage(format!("a WAV file cannot have a rate of {} Hz", Plain(rate))).file(path.display());
        return Err(e.fix("render at a whole number of Hz, up to 1 MHz"));
    }
    if !(1..=MAX_CHANNELS).contains(&channels) {
        let e = FileError::usage(format!("a WAV file cannot have {channels} channels")).file(path.display());
        return Err(e.fix(format!("choose 1 to {MAX_CHANNELS} outputs")));
    }
    Ok(())
}

/// Refuses samples that are not whole frames.
fn whole(path: &Path, samples: usize, channels: usize) -> Result<(), FileError> {
    if samples.is_multiple_of(channels) {
        return Ok(());
    }
    let what = format!("{samples} samples are not whole frames of {channels} channels");
    Err(FileError::usage(what).file(path.display()))
}

/// A WAV file being written.
pub struct WavOut {
    // before `staged`, so that it is closed before the hidden file is removed
    file: File,
    staged: AtomicFile,
    format: Format,
    /// Keeps floats beyond full scale.
    unlimited: bool,
    /// Header with open sizes.
    header: Vec<u8>,
    /// Bytes not yet written to the file.
    bytes: Vec<u8>,
    written: Written,
}

impl WavOut {
    /// Begins the file at `path`, with a whole-number `rate` \[Hz\] and 1 to [`MAX_CHANNELS`] channels.
    ///
    /// # Errors
    /// If the file cannot be created, or a WAV cannot have this rate or number of channels.
    pub fn create(path: impl AsRef<Path>, rate: f64, channels: usize, format: Format) -> Result<WavOut, FileError> {
        let path = path.as_ref();
        WavOut::over(AtomicFile::create(path)?, path, rate, channels, format)
    }

    /// As [`WavOut::create`], over a file already begun, which messages call `path`.
    ///
    /// # Errors
    /// As [`WavOut::create`].
    pub fn over(
        staged: AtomicFile,
        path: &Path,
        rate: f64,
        channels: usize,
        format: Format,
    ) -> Result<WavOut, FileError> {
        shape(path, rate, channels)?;
        let header = wav_header::open(format, rate as u32, channels as u16);
        let file = staged.handle()?;
        let written = Written { path: path.to_owned(), frames: 0, rate: rate as u32, level: Level::new(channels) };
        let bytes = header.clone();
        Ok(WavOut { file, staged, format, unlimited: false, header, bytes, written })
    }

    /// Returns the file with floats beyond full scale kept.
    #[must_use]
    pub fn unlimited(self) -> WavOut {
        WavOut { unlimited: self.format == Format::F32, ..self }
    }

    /// Appends whole frames of interleaved samples.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        let n = self.written.level.peak.len();
        whole(&self.written.path, frames.len(), n)?;
        let from = self.bytes.len();
        self.bytes.resize(from + frames.len() * usize::from(self.format.bits() / 8), 0);
        let (level, to) = (&mut self.written.level, &mut self.bytes[from..]);
        // one loop for each format, so that samples do not branch on the format
        match self.format {
            Format::F32 if self.unlimited => each(frames, level, to, Level::pass, |x| (x as f32).to_le_bytes()),
            Format::F32 => each(frames, level, to, Level::count, |x| (x as f32).to_le_bytes()),
            Format::I24 => each(frames, level, to, Level::count, |x| {
                let [a, b, c, _] = integer(x, 8_388_608.0).to_le_bytes();
                [a, b, c]
            }),
            Format::I16 => each(frames, level, to, Level::count, |x| (integer(x, 32_768.0) as i16).to_le_bytes()),
        }
        self.written.frames += (frames.len() / n) as u64;
        if self.bytes.len() >= ROOM { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), FileError> {
        let done = self.file.write_all(&self.bytes);
        self.bytes.clear();
        done.map_err(|e| FileError::io(&self.written.path, "it cannot be written", &e))
    }

    /// Returns the numbers of [`WavOut::finish`], so far.
    pub fn so_far(&self) -> &Written {
        &self.written
    }

    /// Completes the file and puts it in its place.
    ///
    /// # Errors
    /// If the disk is full; the file is then removed.
    pub fn finish(mut self) -> Result<Written, FileError> {
        self.flush()?;
        self.complete()
    }

    /// Completes the file after the disk became full, with the whole frames that were written, because a performance
    /// cannot be repeated. Levels include all samples given.
    ///
    /// # Errors
    /// If no frame was written, or the file cannot be completed; the file is then removed.
    pub fn finish_short(mut self) -> Result<Written, FileError> {
        let _ = self.flush();
        let (frame, header) = (self.frame(), self.header.len() as u64);
        let failed = |e: &std::io::Error| FileError::io(&self.written.path, "it cannot be written", e);
        let length = self.file.metadata().map_err(|e| failed(&e))?.len();
        let frames = length.saturating_sub(header) / frame;
        // an even number of bytes, because a full disk cannot take a pad byte
        let frames = frames - frames * frame % 2;
        if frames == 0 {
            return Err(FileError::content("no frame was written to the disk").file(self.written.path.display()));
        }
        self.file.set_len(header + frames * frame).map_err(|e| failed(&e))?;
        self.written.frames = frames;
        self.complete()
    }

    /// Returns the bytes of a frame.
    fn frame(&self) -> u64 {
        (self.written.level.peak.len() * usize::from(self.format.bits() / 8)) as u64
    }

    fn complete(self) -> Result<Written, FileError> {
        let data = self.written.frames * self.frame();
        let WavOut { mut file, staged, format, mut header, written, .. } = self;
        wav_header::close(&mut header, format, written.frames, data);
        // chunks begin at even offsets
        let pad = &[0][..(data % 2) as usize];
        let end = SeekFrom::Start(header.len() as u64 + data);
        let put = file.seek(end).and_then(|_| file.write_all(pad));
        put.and_then(|()| file.seek(SeekFrom::Start(0)))
            .and_then(|_| file.write_all(&header))
            .map_err(|e| FileError::io(&written.path, "it cannot be written", &e))?;
        staged.commit()?;
        Ok(written)
    }
}

/// Returns the bytes of a WAV file of 32-bit floats from whole frames of interleaved samples.
pub fn floats(samples: &[f32], channels: usize, rate: u32) -> Vec<u8> {
    let mut bytes = wav_header::open(Format::F32, rate, channels as u16);
    let frames = samples.len() / channels.max(1);
    wav_header::close(&mut bytes, Format::F32, frames as u64, 4 * samples.len() as u64);
    bytes.extend(samples.iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

pub(crate) fn integer(x: f64, full: f64) -> i32 {
    (x * full).round_ties_even().min(full - 1.0) as i32
}

/// Passes every sample through `keep`, which counts it, and writes it as bytes.
#[inline]
fn each<const N: usize>(
    frames: &[f64],
    level: &mut Level,
    to: &mut [u8],
    keep: impl Fn(&mut Level, usize, f64) -> f64,
    as_bytes: impl Fn(f64) -> [u8; N],
) {
    let n = level.peak.len();
    let to = to.as_chunks_mut::<N>().0;
    // most blocks are within full scale: loops without branches, which are vectorised
    if frames.iter().fold(true, |all, x| all & (x.abs() <= 1.0)) {
        for (channel, peak) in level.peak.iter_mut().enumerate() {
            *peak = frames
                .iter()
                .skip(channel)
                .step_by(n)
                .fold(*peak, |most, x| if x.abs() > most { x.abs() } else { most });
        }
        frames.iter().zip(to).for_each(|(x, to)| *to = as_bytes(*x));
        return;
    }
    for ((x, to), channel) in frames.iter().zip(to).zip((0..n).cycle()) {
        *to = as_bytes(keep(level, channel, *x));
    }
}

#[cfg(test)]
#[path = "sound_tests.rs"]
mod tests;
