//! FLAC recordings, such as the results of a sweep.
//!
//! Full scale is 1, as in WAV files: integers of n bits are divided by 2ⁿ⁻¹. The header does not cause an allocation.
//! The number of samples is limited, because a few bytes of FLAC can encode 65 535 equal samples.

use crate::error::{FileError, FileErrorKind, lower};
use crate::read_limited::GESTURE;
use flac_codec::Error;
use flac_codec::decode::FlacSampleReader;
use flac_codec::metadata::Metadata as _;

/// Largest number of samples in all channels: the number in the largest 16-bit WAV file that is read.
const MOST: usize = GESTURE.megabytes as usize * 500_000;

/// Returns the rate \[Hz\] of a FLAC file and the samples of each channel.
pub(super) fn channels(bytes: &[u8]) -> Result<(f64, Vec<Vec<f64>>), FileError> {
    let mut file = FlacSampleReader::new(bytes).map_err(|e| explain(&e))?;
    let about = file.metadata();
    let (rate, n) = (about.sample_rate(), usize::from(about.channel_count()));
    let (bits, announced) = (about.bits_per_sample(), about.total_samples());
    if rate == 0 {
        return Err(FileError::content("its rate is 0 Hz"));
    }
    let full = f64::from(bits.saturating_sub(1)).exp2();
    let mut channels = vec![Vec::new(); n];
    loop {
        let there = channels[0].len();
        // the decoder counts down from the announced number
        if announced.is_some_and(|all| there as u64 > all) {
            return Err(FileError::format("it contains more samples than its header announces"));
        }
        let samples = file.fill_buf().map_err(|e| explain(&e).at(format!("sample {there}")))?;
        if samples.is_empty() {
            break;
        }
        if there * n + samples.len() > MOST {
            let what = format!("it contains more than {} million samples, the limit for a recording", MOST / 1_000_000);
            return Err(FileError::content(what).fix(GESTURE.fix));
        }
        for (i, s) in samples.iter().enumerate() {
            channels[i % n].push(f64::from(*s) / full);
        }
        let read = samples.len();
        file.consume(read);
    }
    match (channels[0].len() as u64, announced) {
        (0, _) => Err(FileError::content("it contains no samples")),
        (there, Some(all)) if there < all => Err(FileError::format("the file is cut short")),
        _ => Ok((f64::from(rate), channels)),
    }
}

fn explain(e: &Error) -> FileError {
    match e {
        Error::Io(_) => FileError::format("the file is cut short"),
        Error::MissingFlacTag => FileError::format("it is not a FLAC file"),
        e => FileError::new(FileErrorKind::Format, format!("it is not a valid FLAC file: {}", lower(&e.to_string())))
            .fix("save it again, or as `.wav`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flac_codec::encode::{FlacSampleWriter, Options};
    use std::io::Cursor;

    fn flac(bits: u32, channels: u8, samples: &[i32]) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        let n = Some(samples.len() as u64);
        let mut out = FlacSampleWriter::new(&mut file, Options::default(), 8000, bits, channels, n).unwrap();
        out.write(samples).unwrap();
        out.finalize().unwrap();
        file.into_inner()
    }

    #[test]
    fn full_scale_is_one_at_every_width() {
        for bits in [8, 12, 16, 20, 24, 32] {
            let low = -(1_i64 << (bits - 1)) as i32;
            let half = (1_i64 << (bits - 2)) as i32;
            let found = channels(&flac(bits, 2, &[low, half, 0, -half])).unwrap();
            assert_eq!(found, (8000.0, vec![vec![-1.0, 0.0], vec![0.5, -0.5]]), "{bits} bits");
        }
    }

    /// A cut or damaged file gives an error or a sound, never a panic.
    #[test]
    fn what_is_cut_or_damaged_gets_an_answer() {
        let sound: Vec<i32> = (0..20_000).map(|i| ((i * i) % 1999 - 1000) * 30).collect();
        let whole = flac(16, 2, &sound);
        assert_eq!(channels(&whole).unwrap().1[0].len(), 10_000);
        for cut in (0..whole.len()).step_by(whole.len() / 300 + 1) {
            assert!(channels(&whole[..cut]).is_err(), "{cut}");
        }
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize
        };
        for _ in 0..2000 {
            let mut bad = whole.clone();
            for _ in 0..1 + next() % 4 {
                // half of the damage is in the header, whose bytes have no checksum
                let at = if next() % 2 == 0 { next() % 60 } else { next() % bad.len() };
                bad[at] = next() as u8;
            }
            let _ = channels(&bad);
        }
        assert!(channels(b"mine").unwrap_err().to_string().contains("not a FLAC file"));
    }
}
