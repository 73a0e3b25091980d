//! WAV gestures: every channel a track, `ch0`, `ch1`, …
//!
//! Decides that full scale is 1 and nothing more, one metre or one newton at a port: a recorded hand fills a small part
//! of it, so floats serve best. Integers of 8, 16, 24 and 32 bits are divided by 2ⁿ⁻¹, so that the most negative one is −1 exactly, and
//! the writer of sounds agrees to the bit. Floats, of 32 or 64 bits, may exceed 1; they may not be infinite.

use super::riff::Chunks;
use super::{Gesture, Track};
use crate::error::{FileError, FileErrorKind, lower};
use hound::{SampleFormat, WavReader};
use std::io::Read;

/// Reads a WAV gesture.
pub(super) fn read(bytes: &[u8]) -> Result<Gesture, FileError> {
    let (rate, channels) = channels(bytes)?;
    let tracks = channels.into_iter().enumerate().map(|(c, v)| Track::sampled(format!("ch{c}"), rate, v));
    Gesture::new(tracks.collect::<Result<_, _>>()?)
}

/// The rate \[Hz\] of a WAV file and the samples of each of its channels.
pub(crate) fn channels(bytes: &[u8]) -> Result<(f64, Vec<Vec<f64>>), FileError> {
    let chunks = Chunks::find(bytes);
    if let Some((found, of)) = chunks.as_ref().and_then(|c| Some((c, c.doubles()?))) {
        let (samples, rest) = found.data.as_chunks::<8>();
        let mut channels = room(of.rate, of.channels, samples.len() / usize::from(of.channels))?;
        spread(&mut channels, samples.iter().map(|v| Ok(f64::from_le_bytes(*v))))?;
        if found.is_cut() {
            return Err(explain(&hound::Error::IoError(std::io::ErrorKind::UnexpectedEof.into())));
        }
        if !rest.is_empty() || !samples.len().is_multiple_of(channels.len()) {
            return Err(explain(&hound::Error::UnfinishedSample));
        }
        return Ok((f64::from(of.rate), channels));
    }
    // what is no WAV file is explained as it is
    let (header, data) = chunks.as_ref().map_or((bytes.to_vec(), &[][..]), |c| (c.header(), c.data));
    let mut file = WavReader::new(header.as_slice().chain(data)).map_err(|e| explain(&e))?;
    let spec = file.spec();
    // a header may announce more than the file holds: memory is for what is there
    let frames = (file.duration() as usize).min(bytes.len() / usize::from(spec.channels));
    let mut channels = room(spec.sample_rate, spec.channels, frames)?;
    match spec.sample_format {
        SampleFormat::Int => {
            let full = f64::from(spec.bits_per_sample.saturating_sub(1)).exp2();
            spread(&mut channels, file.samples::<i32>().map(|s| s.map(|v| f64::from(v) / full)))?;
        }
        SampleFormat::Float => spread(&mut channels, file.samples::<f32>().map(|s| s.map(f64::from)))?,
    }
    Ok((f64::from(spec.sample_rate), channels))
}

/// Room for so many frames.
fn room(rate: u32, channels: u16, frames: usize) -> Result<Vec<Vec<f64>>, FileError> {
    if rate == 0 {
        return Err(FileError::content("its rate is 0 Hz"));
    }
    if frames == 0 {
        return Err(FileError::content("it holds no sample"));
    }
    Ok((0..channels).map(|_| Vec::with_capacity(frames)).collect())
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
                .fix("save it as 8, 16, 24 or 32-bit integers or as floats")
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

    /// A file with a chunk between the format and the samples.
    fn with_chunk(file: &[u8], chunk: &[u8]) -> Vec<u8> {
        [&file[..36], chunk, &file[36..]].concat()
    }

    #[test]
    fn what_other_programs_write_is_read() {
        let file = wav(1, 16, SampleFormat::Int, &[1i32, 2, 3]);
        let of = |bytes: &[u8]| channels(bytes).unwrap();
        let plain = of(&file);
        assert_eq!(plain.1, [[1.0, 2.0, 3.0].map(|v| v / 32768.0)]);
        // names of the artist and of the program, of an odd number of bytes, which one more fills up
        assert_eq!(of(&with_chunk(&file, b"LIST\x05\0\0\0INFOx\0")), plain);
        assert_eq!(of(&with_chunk(&file, b"LIST\x04\0\0\0INFO")), plain);
        // written to a pipe, which cannot be gone back in
        let mut piped = file.clone();
        piped[40..44].fill(0xff);
        piped.push(0);
        assert_eq!(of(&piped), plain);
    }

    /// As SciPy writes an array, `extensible` as other programs do.
    fn doubles(samples: &[f64], extensible: bool) -> Vec<u8> {
        let mut file = wav(2, 32, SampleFormat::Float, &[0f32; 2])[..36].to_vec();
        let (kind, more) = if extensible { (0xfffe_u16, 24) } else { (3, 0) };
        file[16..20].copy_from_slice(&(16 + more as u32).to_le_bytes());
        file[20..22].copy_from_slice(&kind.to_le_bytes());
        file[32..36].copy_from_slice(&[16, 0, 64, 0]);
        let mut rest = vec![0; more];
        if extensible {
            (rest[0], rest[2], rest[8]) = (22, 64, 3);
        }
        file.extend(rest);
        file.extend(b"data");
        file.extend((8 * samples.len() as u32).to_le_bytes());
        file.extend(samples.iter().flat_map(|v| v.to_le_bytes()));
        file
    }

    #[test]
    fn floats_of_64_bits_are_read() {
        let samples = [0.1, -1.5, 1e-300, 0.25];
        for extensible in [false, true] {
            let file = doubles(&samples, extensible);
            assert_eq!(channels(&file).unwrap(), (8000.0, vec![vec![0.1, 1e-300], vec![-1.5, 0.25]]));
            let said = |bytes: &[u8]| channels(bytes).unwrap_err().to_string();
            assert!(said(&file[..file.len() - 8]).contains("cut short"), "{}", said(&file[..file.len() - 8]));
            let at = file.len() - 36;
            let mut odd = file.clone();
            odd[at..at + 4].copy_from_slice(&24u32.to_le_bytes());
            assert!(said(&odd).contains("not whole"), "{}", said(&odd));
            odd[at..at + 4].fill(0);
            assert!(said(&odd).contains("no sample"), "{}", said(&odd));
        }
        let e = channels(&doubles(&[0.0, 0.0, f64::INFINITY, 0.0], false)).unwrap_err();
        assert_eq!(e.to_string(), "sample 1 of channel 0: the value is inf");
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
