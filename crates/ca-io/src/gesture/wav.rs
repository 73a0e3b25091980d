//! WAV gestures: every channel a track, `ch0`, `ch1`, …
//!
//! Decides that full scale is 1 and nothing more, one metre or one newton at a port: a recorded hand fills a small part
//! of it, so floats serve best. Integers of 8, 16, 24 and 32 bits are divided by 2ⁿ⁻¹, so that the most negative one is −1 exactly, and
//! the writer of sounds agrees to the bit. Floats may exceed 1; they may not be infinite.

use super::{Gesture, Track};
use crate::error::{FileError, FileErrorKind, lower};
use hound::{SampleFormat, WavReader};

/// Reads a WAV gesture.
pub(super) fn read(bytes: &[u8]) -> Result<Gesture, FileError> {
    let (rate, channels) = channels(bytes)?;
    let tracks = channels.into_iter().enumerate().map(|(c, v)| Track::sampled(format!("ch{c}"), rate, v));
    Gesture::new(tracks.collect::<Result<_, _>>()?)
}

/// The rate \[Hz\] of a WAV file and the samples of each of its channels.
pub(crate) fn channels(bytes: &[u8]) -> Result<(f64, Vec<Vec<f64>>), FileError> {
    let mut file = WavReader::new(bytes).map_err(|e| explain(&e))?;
    let spec = file.spec();
    if spec.sample_rate == 0 {
        return Err(FileError::content("its rate is 0 Hz"));
    }
    // a header may announce more than the file holds: memory is for what is there
    let frames = (file.duration() as usize).min(bytes.len() / usize::from(spec.channels));
    if frames == 0 {
        return Err(FileError::content("it holds no sample"));
    }
    let mut channels: Vec<Vec<f64>> = (0..spec.channels).map(|_| Vec::with_capacity(frames)).collect();
    match spec.sample_format {
        SampleFormat::Int => {
            let full = f64::from(spec.bits_per_sample.saturating_sub(1)).exp2();
            spread(&mut channels, file.samples::<i32>().map(|s| s.map(|v| f64::from(v) / full)))?;
        }
        SampleFormat::Float => spread(&mut channels, file.samples::<f32>().map(|s| s.map(f64::from)))?,
    }
    Ok((f64::from(spec.sample_rate), channels))
}

/// Deals interleaved samples out to their channels.
fn spread(channels: &mut [Vec<f64>], samples: impl Iterator<Item = hound::Result<f64>>) -> Result<(), FileError> {
    let n = channels.len();
    for (i, s) in samples.enumerate() {
        let s = s.map_err(|e| explain(&e).at(format!("sample {} of channel {}", i / n, i % n)))?;
        if !s.is_finite() {
            let place = format!("sample {} of channel {}", i / n, i % n);
            return Err(FileError::content(format!("the value is {s}")).at(place));
        }
        channels[i % n].push(s);
    }
    Ok(())
}

fn explain(e: &hound::Error) -> FileError {
    match e {
        hound::Error::Unsupported | hound::Error::TooWide | hound::Error::InvalidSampleFormat => {
            FileError::new(FileErrorKind::Unsupported, "this variety of WAV is not read")
                .fix("save it as 8, 16, 24 or 32-bit integers or as 32-bit floats")
        }
        hound::Error::IoError(_) => FileError::format("the file is cut short"),
        hound::Error::FormatError(what) => FileError::format(format!("it is not a WAV file: {}", lower(what))),
        hound::Error::UnfinishedSample => FileError::format("its last frame is not whole"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::{Sample, WavSpec, WavWriter};
    use std::io::Cursor;

    fn wav<S: Sample + Copy>(channels: u16, bits: u16, format: SampleFormat, samples: &[S]) -> Vec<u8> {
        let spec = WavSpec { channels, sample_rate: 8000, bits_per_sample: bits, sample_format: format };
        let mut out = Cursor::new(Vec::new());
        let mut w = WavWriter::new(&mut out, spec).unwrap();
        for s in samples {
            w.write_sample(*s).unwrap();
        }
        w.finalize().unwrap();
        out.into_inner()
    }

    #[test]
    fn full_scale_is_one_at_every_width() {
        for bits in [8, 16, 24, 32] {
            let low = -(1i64 << (bits - 1)) as i32;
            let half = (1i64 << (bits - 2)) as i32;
            let g = read(&wav(2, bits, SampleFormat::Int, &[low, half, 0, -half])).unwrap();
            assert_eq!(g.tracks().iter().map(Track::name).collect::<Vec<_>>(), ["ch0", "ch1"]);
            let (a, b) = (&g.tracks()[0], &g.tracks()[1]);
            assert_eq!([a.at(0.0), b.at(0.0), a.at(1.0), b.at(1.0)], [-1.0, 0.5, 0.0, -0.5], "{bits} bits");
            assert_eq!(a.duration(), 1.0 / 8000.0);
            assert_eq!(a.at(0.5 / 8000.0), -0.5);
        }
        let g = read(&wav(1, 32, SampleFormat::Float, &[0.25f32, -3.0])).unwrap();
        assert_eq!((g.tracks()[0].at(0.0), g.tracks()[0].at(1.0)), (0.25, -3.0));
    }

    #[test]
    fn bad_content_is_named() {
        let e = read(&wav(2, 32, SampleFormat::Float, &[0.0f32, 0.0, 0.0, f32::NAN])).unwrap_err();
        assert_eq!(e.to_string(), "sample 1 of channel 1: the value is NaN");
        let e = read(&wav::<i32>(1, 16, SampleFormat::Int, &[])).unwrap_err();
        assert!(e.to_string().contains("no sample"), "{e}");
        let whole = wav(1, 16, SampleFormat::Int, &[1i32, 2, 3, 4]);
        let e = read(&whole[..whole.len() - 3]).unwrap_err();
        assert_eq!((e.kind, e.place.as_str()), (FileErrorKind::Format, "sample 2 of channel 0"));
        assert!(read(b"RIFX").is_err());
        assert!(read(b"not a wave file at all, whatever").unwrap_err().to_string().contains("not a WAV file"));
        // a rate of 0, which hound accepts where the bytes per second agree
        let mut dead = whole.clone();
        dead[24..32].fill(0);
        assert!(read(&dead).unwrap_err().to_string().contains("0 Hz"));
        // a header that promises 4 GB makes no such vector
        let mut vast = whole;
        vast[40..44].copy_from_slice(&0xffff_fff0u32.to_le_bytes());
        assert_eq!(read(&vast).unwrap_err().kind, FileErrorKind::Format);
    }
}
