//! WAV gestures: every channel becomes a track, `ch0`, `ch1`, …
//!
//! Full scale is 1, that is one metre or one newton at a port. A recorded hand uses a small part of it, so floats are
//! best. Integers of 8, 16, 24 and 32 bits are divided by 2ⁿ⁻¹, so that the most negative one is −1 exactly; the writer
//! of sounds is the inverse, to the bit. Samples with fewer bits than their bytes hold use the high bits, as in
//! libsndfile. Floats, of 32 or 64 bits, may exceed 1 but must be finite.

use super::riff::{Chunks, Format};
use super::{Gesture, Track};
use crate::error::{FileError, FileErrorKind};

pub(super) fn read(bytes: &[u8]) -> Result<Gesture, FileError> {
    let (rate, channels) = channels(bytes)?;
    let tracks = channels.into_iter().enumerate().map(|(c, v)| Track::sampled(format!("ch{c}"), rate, v));
    Gesture::new(tracks.collect::<Result<_, _>>()?)
}

/// Returns the rate \[Hz\] of a WAV file and the samples of each channel.
pub(crate) fn channels(bytes: &[u8]) -> Result<(f64, Vec<Vec<f64>>), FileError> {
    let no_wav = |what: &str| FileError::format(format!("it is not a WAV file: {what}"));
    let Chunks { format, data, announced } = Chunks::find(bytes).map_err(no_wav)?;
    if format.channels == 0 {
        return Err(no_wav("its number of channels is 0"));
    }
    let value = decoder(format, data)?;
    let (samples, n) = (data.len() / format.bytes, format.channels);
    let place = |i: usize| format!("sample {} of channel {}", i / n, i % n);
    if (data.len() as u64) < announced {
        return Err(FileError::format("the file is cut short").at(place(samples)));
    }
    if !data.len().is_multiple_of(format.bytes * n) {
        return Err(FileError::format("its last frame is incomplete"));
    }
    if format.rate == 0 {
        return Err(FileError::content("its rate is 0 Hz"));
    }
    if samples == 0 {
        return Err(FileError::content("it contains no samples"));
    }
    let mut channels: Vec<Vec<f64>> = (0..n).map(|_| Vec::with_capacity(samples / n)).collect();
    for (i, bytes) in data.chunks_exact(format.bytes).enumerate() {
        let x = value(bytes);
        if !x.is_finite() {
            return Err(FileError::content(format!("the value is {x}, not a finite number")).at(place(i)));
        }
        channels[i % n].push(x);
    }
    Ok((f64::from(format.rate), channels))
}

type Decoder = Box<dyn Fn(&[u8]) -> f64>;

fn decoder(format: Format, data: &[u8]) -> Result<Decoder, FileError> {
    const INTEGERS: u32 = 1;
    const FLOATS: u32 = 3;
    let wide = 8 * format.bytes as u32;
    Ok(match (format.kind, format.bytes) {
        (FLOATS, 4) => Box::new(|b| f64::from(f32::from_bits(integer(b) as u32))),
        (FLOATS, 8) => Box::new(|b| f64::from_le_bytes(b.try_into().unwrap_or_default())),
        // unsigned
        (INTEGERS, 1) if format.bits <= 8 => Box::new(|b| (f64::from(b[0]) - 128.0) / 128.0),
        (INTEGERS, 2..=4) if (1..=wide).contains(&format.bits) => {
            let bits = if at_the_low_end(format, data) { format.bits } else { wide };
            let full = f64::from(bits - 1).exp2();
            Box::new(move |b| f64::from(integer(b) << (32 - wide) >> (32 - wide)) / full)
        }
        _ => {
            let e = FileError::new(FileErrorKind::Unsupported, "this variant of WAV is not supported");
            return Err(e.fix("save it as 8, 16, 24 or 32-bit integers or as floats"));
        }
    })
}

/// Returns true for samples in the low bits of their bytes, as hound writes them. The standard uses the high bits, with
/// zeros below.
fn at_the_low_end(format: Format, data: &[u8]) -> bool {
    let wide = 8 * format.bytes as u32;
    let (unused, above) = (wide - format.bits, 32 - format.bits);
    let all = || data.chunks_exact(format.bytes).map(|b| integer(b) << (32 - wide) >> (32 - wide));
    unused > 0 && all().any(|v| v & !(-1 << unused) != 0) && all().all(|v| v == v << above >> above)
}

/// Reads up to four bytes, little-endian.
fn integer(bytes: &[u8]) -> i32 {
    bytes.iter().rev().fold(0, |n, b| n << 8 | i32::from(*b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::{Sample, SampleFormat, WavSpec, WavWriter};
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

    fn with_chunk(file: &[u8], chunk: &[u8]) -> Vec<u8> {
        [&file[..36], chunk, &file[36..]].concat()
    }

    #[test]
    fn what_other_programs_write_is_read() {
        let file = wav(1, 16, SampleFormat::Int, &[1i32, 2, 3]);
        let of = |bytes: &[u8]| channels(bytes).unwrap();
        let plain = of(&file);
        assert_eq!(plain.1, [[1.0, 2.0, 3.0].map(|v| v / 32768.0)]);
        // a chunk of an odd number of bytes, with its pad byte
        assert_eq!(of(&with_chunk(&file, b"LIST\x05\0\0\0INFOx\0")), plain);
        assert_eq!(of(&with_chunk(&file, b"LIST\x04\0\0\0INFO")), plain);
        // written to a pipe, without seeking back
        let mut piped = file.clone();
        piped[40..44].fill(0xff);
        piped.push(0);
        assert_eq!(of(&piped), plain);
    }

    /// Makes a file as SciPy writes an array, or `extensible` as other programs do.
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
            assert!(said(&odd).contains("incomplete"), "{}", said(&odd));
            odd[at..at + 4].fill(0);
            assert!(said(&odd).contains("no sample"), "{}", said(&odd));
        }
        let e = channels(&doubles(&[0.0, 0.0, f64::INFINITY, 0.0], false)).unwrap_err();
        assert_eq!(e.to_string(), "sample 1 of channel 0: the value is inf, not a finite number");
    }

    /// Makes a file of integers of `bits` bits in `bytes` bytes each.
    fn integers(bytes: u16, bits: u16, samples: &[i32]) -> Vec<u8> {
        let mut file = b"RIFF\xff\xff\xff\xffWAVEfmt \x28\0\0\0\xfe\xff\x01\0\xb8\x0b\0\0".to_vec();
        file.extend((3000 * u32::from(bytes)).to_le_bytes());
        file.extend([bytes, 8 * bytes, 22, bits].iter().flat_map(|v| v.to_le_bytes()));
        file.extend(b"\x04\0\0\0\x01\0\0\0\0\0\x10\0\x80\0\0\xaa\0\x38\x9b\x71data");
        file.extend((samples.len() as u32 * u32::from(bytes)).to_le_bytes());
        file.extend(samples.iter().flat_map(|v| v.to_le_bytes()[..usize::from(bytes)].to_vec()));
        file
    }

    #[test]
    fn fewer_bits_than_bytes_stand_at_the_high_end() {
        let of = |bytes, bits, samples: &[i32]| channels(&integers(bytes, bits, samples)).unwrap().1.remove(0);
        let (full, half) = (-(1 << 23), 1 << 22);
        assert_eq!(of(4, 24, &[full << 8, half << 8, 3 << 8]), [-1.0, 0.5, 3.0 / 8_388_608.0]);
        assert_eq!(of(3, 20, &[full, half, 16]), [-1.0, 0.5, 16.0 / 8_388_608.0]);
        assert_eq!(of(2, 12, &[-32_768, 16_384]), [-1.0, 0.5]);
        // in the low bits, as hound writes them
        assert_eq!(of(4, 24, &[full, half, 3]), [-1.0, 0.5, 3.0 / 8_388_608.0]);
        // all bits are significant
        assert_eq!(of(4, 32, &[i32::MIN, 1 << 30, 3]), [-1.0, 0.5, 3.0 / 2_147_483_648.0]);
        assert!(channels(&integers(2, 17, &[1])).unwrap_err().to_string().contains("variant"));
        assert!(channels(&integers(0, 0, &[])).is_err());
    }

    #[test]
    fn open_sizes_go_on_to_the_end() {
        let file = wav(1, 16, SampleFormat::Int, &[1i32, 2, 3]);
        let plain = channels(&file).unwrap();
        let sized = |whole: u32, data: u32| {
            let mut file = file.clone();
            file[4..8].copy_from_slice(&whole.to_le_bytes());
            file[40..44].copy_from_slice(&data.to_le_bytes());
            channels(&file)
        };
        let lasts = [u32::MAX, u32::MAX - 1, 0x8000_0000, 0x7fff_ffff].map(|data| (u32::MAX, data));
        let others = [
            (0, 0),
            (u32::MAX, 0),
            (0x7fff_f024, 0x7fff_f000),
            (42, u32::MAX),
            (u32::MAX, u32::MAX - 36),
            (0x7fff_ffff, 0x7fff_ffdb),
        ];
        for (whole, data) in lasts.into_iter().chain(others) {
            assert_eq!(sized(whole, data).as_ref(), Ok(&plain), "{whole:#x} {data:#x}");
        }
        // a file of known length without samples
        assert!(sized(36, 0).unwrap_err().to_string().contains("no sample"));
        assert!(sized(0x7fff_f023, 0x7fff_efff).unwrap_err().to_string().contains("cut short"));
    }

    #[test]
    fn sizes_of_64_bits_are_read() {
        let file = wav(1, 16, SampleFormat::Int, &[1i32, 2, 3]);
        let plain = channels(&file).unwrap();
        let long = |tag: &[u8; 4], whole: u64, data: u64, short: u32| {
            let mut head = tag.to_vec();
            head.extend(b"\xff\xff\xff\xffWAVEds64\x1c\0\0\0");
            head.extend([whole, data, 3].iter().flat_map(|v| v.to_le_bytes()));
            head.extend([0; 4]);
            let mut rest = file[12..].to_vec();
            rest[28..32].copy_from_slice(&short.to_le_bytes());
            channels(&[head, rest].concat())
        };
        for tag in [b"RF64", b"BW64"] {
            for (whole, data, short) in [(78, 6, u32::MAX), (0, 6, u32::MAX), (78, 0, 6), (0, 0, u32::MAX)] {
                assert_eq!(long(tag, whole, data, short).as_ref(), Ok(&plain), "{whole} {data} {short}");
            }
        }
        assert!(long(b"RF64", 1 << 40, 1 << 40, u32::MAX).unwrap_err().to_string().contains("cut short"));
    }

    #[test]
    fn bad_content_is_named() {
        let e = read(&wav(2, 32, SampleFormat::Float, &[0.0f32, 0.0, 0.0, f32::NAN])).unwrap_err();
        assert_eq!(e.to_string(), "sample 1 of channel 1: the value is NaN, not a finite number");
        let e = read(&wav::<i32>(1, 16, SampleFormat::Int, &[])).unwrap_err();
        assert!(e.to_string().contains("no sample"), "{e}");
        let whole = wav(1, 16, SampleFormat::Int, &[1i32, 2, 3, 4]);
        let e = read(&whole[..whole.len() - 3]).unwrap_err();
        assert_eq!((e.kind, e.place.as_str()), (FileErrorKind::Format, "sample 2 of channel 0"));
        assert!(read(b"RIFX").is_err());
        assert!(read(b"not a wave file at all, whatever").unwrap_err().to_string().contains("not a WAV file"));
        // a rate of 0, which hound accepts if the bytes per second agree
        let mut dead = whole.clone();
        dead[24..32].fill(0);
        assert!(read(&dead).unwrap_err().to_string().contains("0 Hz"));
        // a header that promises 4 GB does not allocate them
        let mut vast = whole;
        vast[40..44].copy_from_slice(&0xf000_0000u32.to_le_bytes());
        assert_eq!(read(&vast).unwrap_err().kind, FileErrorKind::Format);
    }
}
