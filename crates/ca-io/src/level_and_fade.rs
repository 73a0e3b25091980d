//! Level and ending of the sound file of a render.
//!
//! Float files keep the output of the model, also beyond full scale; a gain can correct it later. A sound that has not
//! died away is faded over its last 20 ms, because the abrupt end would click; all other samples keep their bits.
//! Clipping and fading apply only to files: computations on a render use its full output.
//!
//! A normalised render is written twice, first as floats, because its peak is known only at the end. Floats to a pipe
//! are also written twice, because a divergence of the model is known only at the end.

use crate::atomic_file::AtomicFile;
use crate::error::FileError;
use crate::flac::FlacOut;
use crate::format::Format;
use crate::sound::{WavOut, Written};
use crate::wav_header;
use std::f64::consts::PI;
use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

/// Length of the fade \[s\].
pub const FADE: f64 = 0.02;
/// Peak below which the end of a sound is not faded: −60 dB of full scale.
pub const QUIET: f64 = 1e-3;
/// Frames rewritten at a time.
const BLOCK: u64 = 1 << 14;

/// Options for writing a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// Sample format.
    pub format: Format,
    /// Writes FLAC instead of WAV.
    pub flac: bool,
    /// Clips floats at full scale, as integers always are.
    pub ceiling: bool,
    /// Fades the end of a sound that has not died away.
    pub fade: bool,
    /// Peak to normalise to, as a share of full scale.
    pub normalize: Option<f64>,
}

impl Ending {
    /// Returns true if samples beyond full scale are kept.
    fn is_unlimited(&self) -> bool {
        self.format == Format::F32 && !self.ceiling && !self.flac
    }

    /// Begins a file of this shape (\[Hz\], channels), of a model that `diverged` or not.
    fn begin(self, to: AtomicFile, path: &Path, shape: (f64, usize), diverged: bool) -> Result<SoundOut, FileError> {
        let (rate, channels) = shape;
        if self.flac {
            return Ok(SoundOut::Flac(Box::new(FlacOut::over(to, path, rate, channels, self.format)?)));
        }
        let out = WavOut::over(to, path, rate, channels, self.format)?;
        Ok(SoundOut::Wav(if self.is_unlimited() && !diverged { out.unlimited() } else { out }))
    }
}

/// Result of writing a render.
#[derive(Clone, Debug, PartialEq)]
pub struct Ended {
    /// Written file.
    pub written: Written,
    /// True if the end was faded.
    pub faded: bool,
    /// Gain applied to all samples.
    pub gain: f64,
}

/// Fades the end of a whole sound (interleaved samples at `rate` \[Hz\]) that has not died away, as [`RenderOut`] does.
pub fn fade_end(sound: &mut [f64], rate: f64, channels: usize) {
    let end = sound.len().saturating_sub(fade_len(rate, channels));
    let last = sound.get_mut(end..).unwrap_or_default();
    if loudest(last) > QUIET {
        fade(last, channels);
    }
}

/// Number of samples in a fade.
fn fade_len(rate: f64, channels: usize) -> usize {
    (rate * FADE).round().max(1.0) as usize * channels
}

fn loudest(all: &[f64]) -> f64 {
    all.iter().filter(|x| x.is_finite()).fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn fade(last: &mut [f64], channels: usize) {
    let n = last.len() / channels;
    for (i, frame) in last.chunks_exact_mut(channels).enumerate() {
        let w = 0.5 + 0.5 * (PI * (i + 1) as f64 / n as f64).cos();
        for x in frame.iter_mut() {
            *x *= w;
        }
    }
}

enum SoundOut {
    Wav(WavOut),
    Flac(Box<FlacOut>),
}

impl SoundOut {
    fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        match self {
            SoundOut::Wav(out) => out.write(frames),
            SoundOut::Flac(out) => out.write(frames),
        }
    }

    fn so_far(&self) -> &Written {
        match self {
            SoundOut::Wav(out) => out.so_far(),
            SoundOut::Flac(out) => out.so_far(),
        }
    }

    fn finish(self) -> Result<Written, FileError> {
        match self {
            SoundOut::Wav(out) => out.finish(),
            SoundOut::Flac(out) => out.finish(),
        }
    }
}

/// A render being written.
pub struct RenderOut {
    out: SoundOut,
    path: PathBuf,
    /// (\[Hz\], channels).
    shape: (f64, usize),
    ending: Ending,
    /// Handle to read back the file being written, if that is possible.
    back: Option<File>,
    /// Target of the second writing, if there always is one.
    last: Option<AtomicFile>,
    /// Last samples so far, kept back for a fade.
    tail: Vec<f64>,
}

impl RenderOut {
    /// Begins the file at `path`, as [`AtomicFile::create`].
    ///
    /// # Errors
    /// The errors of [`WavOut::create`] and [`FlacOut::over`].
    pub fn create(path: &Path, rate: f64, channels: usize, ending: Ending) -> Result<RenderOut, FileError> {
        let to = AtomicFile::create(path)?;
        let (path, shape, tail) = (path.to_owned(), (rate, channels), Vec::new());
        // samples sent through a pipe cannot be clipped afterwards if the model diverges
        let twice = ending.normalize.is_some() || to.is_pipe() && ending.is_unlimited();
        if twice {
            // refuses an impossible format before anything is played
            ending.begin(to.scratch()?, &path, shape, false)?;
            let first = to.scratch()?;
            let back = Some(first.handle()?);
            let out = SoundOut::Wav(WavOut::over(first, &path, rate, channels, Format::F32)?.unlimited());
            return Ok(RenderOut { out, path, shape, ending, back, last: Some(to), tail });
        }
        let back = to.is_plain().then(|| to.handle()).transpose()?;
        let out = ending.begin(to, &path, shape, false)?;
        Ok(RenderOut { out, path, shape, ending, back, last: None, tail })
    }

    /// Returns the number of samples in a fade.
    fn fade_len(&self) -> usize {
        fade_len(self.shape.0, self.shape.1)
    }

    /// Appends whole frames of interleaved samples.
    ///
    /// # Errors
    /// The errors of [`WavOut::write`].
    pub fn write(&mut self, frames: &[f64]) -> Result<(), FileError> {
        let fade_len = self.fade_len();
        self.tail.extend_from_slice(frames);
        if self.tail.len() >= 2 * fade_len {
            let done = self.tail.len() - fade_len;
            self.out.write(&self.tail[..done])?;
            self.tail.drain(..done);
        }
        Ok(())
    }

    /// Completes the file. If the model `diverged`, the file is clipped at full scale and not faded.
    ///
    /// # Errors
    /// The errors of [`WavOut::finish`].
    pub fn finish(mut self, diverged: bool) -> Result<Ended, FileError> {
        let gain = |peak: f64| match self.ending.normalize {
            Some(to) if peak > 0.0 && !diverged => to / peak,
            _ => 1.0,
        };
        let before = loudest(&self.out.so_far().level.peak);
        let (fade_len, tail) = (self.fade_len(), loudest(&self.tail));
        let end = self.tail.len().saturating_sub(fade_len);
        let last = self.tail.get_mut(end..).unwrap_or_default();
        let faded = self.ending.fade && !diverged && gain(before.max(tail)) * loudest(last) > QUIET;
        if faded {
            fade(last, self.shape.1);
        }
        let gain = gain(before.max(loudest(&self.tail)));
        self.out.write(&self.tail)?;
        let again = self.last.is_some() || diverged && self.out.so_far().level.beyond > 0;
        let written = match self.back.take() {
            Some(back) if again => self.again(back, gain, diverged)?,
            _ => self.out.finish()?,
        };
        Ok(Ended { written, faded, gain })
    }

    /// Writes the file a second time, from the samples in `back`.
    fn again(self, mut back: File, gain: f64, diverged: bool) -> Result<Written, FileError> {
        let first = self.out.finish()?;
        let unread = |e: std::io::Error| FileError::io(&first.path, "it cannot be read again", &e);
        let to = self.last.map_or_else(|| AtomicFile::create(&self.path), Ok)?;
        let mut out = self.ending.begin(to, &self.path, self.shape, diverged)?;
        let channels = self.shape.1;
        let header = wav_header::open(Format::F32, first.rate, channels as u16).len();
        back.seek(SeekFrom::Start(header as u64)).map_err(unread)?;
        let mut left = first.frames;
        while left > 0 {
            let n = left.min(BLOCK);
            let mut bytes = vec![0; n as usize * channels * 4];
            back.read_exact(&mut bytes).map_err(unread)?;
            let samples = bytes.as_chunks::<4>().0.iter();
            let block: Vec<f64> = samples.map(|b| f64::from(f32::from_le_bytes(*b)) * gain).collect();
            out.write(&block)?;
            left -= n;
        }
        let mut written = out.finish()?;
        written.level.non_finite = first.level.non_finite;
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::WavReader;

    const ENDING: Ending = Ending { format: Format::F32, flac: false, ceiling: false, fade: true, normalize: None };

    fn render(ending: Ending, samples: &[f64], diverged: bool) -> (Vec<f64>, Ended) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.wav");
        let mut out = RenderOut::create(&path, 1000.0, 2, ending).unwrap();
        samples.chunks(14).for_each(|c| out.write(c).unwrap());
        let ended = out.finish(diverged).unwrap();
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 1, "one file is left");
        let mut file = WavReader::open(&path).unwrap();
        let full = f64::from(ending.format.bits() - 1).exp2();
        let got = match ending.format {
            Format::F32 => file.samples::<f32>().map(|s| f64::from(s.unwrap())).collect(),
            _ => file.samples::<i32>().map(|s| f64::from(s.unwrap()) / full).collect(),
        };
        (got, ended)
    }

    #[test]
    fn a_sound_that_goes_on_is_faded_in_its_last_20_ms_alone() {
        let samples = [0.5, -2.0].repeat(100);
        let (got, ended) = render(ENDING, &samples, false);
        assert!(ended.faded && ended.written.is_faithful());
        assert_eq!((&got[..160], ended.written.level.beyond), (&samples[..160], 100 - 11));
        for i in 0..20 {
            let w = 0.5 + 0.5 * (PI * f64::from(i + 1) / 20.0).cos();
            let at = 160 + 2 * i as usize;
            assert!((got[at] - 0.5 * w).abs() < 1e-7 && (got[at + 1] + 2.0 * w).abs() < 1e-6, "{i}");
        }
        let (got, ended) = render(Ending { fade: false, ..ENDING }, &samples, false);
        assert_eq!((got, ended.faded), (samples.clone(), false));
        // a sound that has died away is not faded; one shorter than a fade is
        let quiet = [[0.5, -2.0].repeat(80), [9e-4, -9e-4].repeat(20)].concat();
        assert!(!render(ENDING, &quiet, false).1.faded);
        let (got, ended) = render(ENDING, &[1.0, 1.0, 1.0, 1.0], false);
        assert_eq!((got, ended.faded), (vec![0.5, 0.5, 0.0, 0.0], true));
    }

    #[test]
    fn it_is_as_loud_as_asked_in_every_format() {
        let samples: Vec<f64> = (0..400).map(|i| 3.0 * (f64::from(i) * 0.1).sin()).collect();
        let peak = samples.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        for (format, step) in [(Format::F32, 1e-6), (Format::I24, 2e-7), (Format::I16, 4e-5)] {
            let ending = Ending { format, fade: false, normalize: Some(0.5), ..ENDING };
            let (got, ended) = render(ending, &samples, false);
            assert!((ended.gain - 0.5 / peak).abs() < 1e-15 && ended.written.is_faithful());
            let far = got.iter().zip(&samples).fold(0.0, |m: f64, (a, b)| m.max((a - b * ended.gain).abs()));
            assert!(far < step, "{format:?}: {far}");
            assert_eq!(render(ending, &[0.0; 40], false).1.gain, 1.0);
        }
    }

    #[test]
    fn what_is_written_twice_takes_no_name_that_somebody_has() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.wav");
        let others = ["a.wav.float", ".a.wav.float"].map(|n| dir.path().join(n));
        for other in &others {
            std::fs::write(other, "precious").unwrap();
        }
        let ending = Ending { normalize: Some(0.5), fade: true, ..ENDING };
        let mut out = RenderOut::create(&path, 1000.0, 1, ending).unwrap();
        out.write(&[0.1, 0.9, 1.0, 1.0]).unwrap();
        let ended = out.finish(false).unwrap();
        assert!(others.iter().all(|o| std::fs::read(o).unwrap() == b"precious"));
        assert_eq!(std::fs::read_dir(&dir).unwrap().count(), 3);
        // the fade comes before the normalisation
        assert!((ended.written.level.peak[0] - 0.5).abs() < 1e-7, "{:?}", ended.written.level);
    }

    /// A pipe gets the same bytes as a file, with every kind of ending.
    #[cfg(unix)]
    #[test]
    fn a_pipe_gets_the_bytes_of_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let (file, fifo) = (dir.path().join("a.wav"), dir.path().join("fifo"));
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        let samples = [0.5, -2.0].repeat(5000);
        let normalize = Ending { normalize: Some(0.5), ..ENDING };
        let flac = Ending { format: Format::I16, flac: true, ..ENDING };
        for (ending, diverged) in [(ENDING, false), (ENDING, true), (normalize, false), (flac, false), (flac, true)] {
            let from = fifo.clone();
            let reader = std::thread::spawn(move || std::fs::read(from).unwrap());
            let [whole, sent] = [&file, &fifo].map(|path| {
                let mut out = RenderOut::create(path, 1000.0, 2, ending).unwrap();
                samples.chunks(14).for_each(|c| out.write(c).unwrap());
                out.finish(diverged).unwrap().written.level
            });
            assert_eq!(whole, sent);
            let bytes = std::fs::read(&file).unwrap();
            // a header of 42 bytes, and equal samples in a few more
            assert!(bytes.len() > 42 && bytes == reader.join().unwrap(), "{ending:?} {diverged}");
        }
    }

    #[test]
    fn a_ceiling_and_a_divergence_keep_within_full_scale() {
        let samples = [0.5, -2.0].repeat(100);
        let ceiling = Ending { ceiling: true, fade: false, ..ENDING };
        let (got, ended) = render(ceiling, &samples, false);
        assert_eq!((got, ended.written.level.clipped), ([0.5, -1.0].repeat(100), 100));
        let (got, ended) = render(ENDING, &samples, true);
        assert_eq!((got, ended.written.level.clipped, ended.faded), ([0.5, -1.0].repeat(100), 100, false));
    }
}
