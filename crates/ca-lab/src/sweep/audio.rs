//! The sound of a run as the bytes of a file.
//!
//! Decides for whole files in memory: a run is short, and it appears with its fellows or not at all (`folder.rs`).

use crate::Failure;
use flacenc::component::BitRepr as _;
use flacenc::error::Verify as _;
use hound::{SampleFormat, WavSpec, WavWriter};
use std::io::Cursor;

/// In which form sounds are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audio {
    /// 24 bits, about half the size
    Flac,
    /// 32-bit floats
    Wav,
    /// not at all
    None,
}

impl Audio {
    /// By its name.
    pub fn named(name: &str) -> Option<Audio> {
        [Audio::Flac, Audio::Wav, Audio::None].into_iter().find(|a| a.name() == name)
    }

    /// Its name, and the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Audio::Flac => "flac",
            Audio::Wav => "wav",
            Audio::None => "none",
        }
    }

    /// Why sounds of this shape cannot be kept so.
    pub fn refuses(self, channels: usize, rate: f64) -> Option<String> {
        let (most, fastest) = match self {
            Audio::Flac => (8, 655_350.0),
            Audio::Wav => (256, 1e6),
            Audio::None => return None,
        };
        let fits = (1..=most).contains(&channels) && rate.fract() == 0.0 && (1.0..=fastest).contains(&rate);
        let name = self.name().to_uppercase();
        (!fits).then(|| {
            let what = format!("{name} holds 1 to {most} channels at whole rates up to {fastest} Hz");
            let fix = if self == Audio::Flac {
                "\"wav\" holds more, \"none\" keeps rows only"
            } else {
                "\"none\" keeps rows only"
            };
            format!("{what}, not {channels} at {rate}; {fix}")
        })
    }

    /// The bytes of a file; none for [`Audio::None`]. Interleaved samples within ±1, whole frames.
    ///
    /// # Errors
    /// [`Failure::Failed`] where the encoder takes none of it.
    pub fn encode(self, samples: &[f32], channels: usize, rate: f64) -> Result<Vec<u8>, Failure> {
        match self {
            Audio::Flac => flac(samples, channels, rate as usize, 24),
            Audio::Wav => wav(samples, channels, rate as u32).map_err(|e| failed(&e.to_string())),
            Audio::None => Ok(Vec::new()),
        }
    }
}

/// The bytes of a FLAC file of 16 bits: two thirds of the room of 24, for what is only listened to. Interleaved samples within ±1,
/// whole frames.
///
/// # Errors
/// [`Failure::Failed`] where the encoder takes none of it.
pub fn flac16(samples: &[f32], channels: usize, rate: f64) -> Result<Vec<u8>, Failure> {
    flac(samples, channels, rate as usize, 16)
}

fn failed(why: &str) -> Failure {
    Failure::Failed(format!("a sound cannot be encoded: {why}"))
}

fn flac(samples: &[f32], channels: usize, rate: usize, bits: usize) -> Result<Vec<u8>, Failure> {
    let full = f64::from(1_u32 << (bits - 1));
    let whole = |x: &f32| (f64::from(*x) * full).round_ties_even().min(full - 1.0) as i32;
    let samples: Vec<i32> = samples.iter().map(whole).collect();
    let config = flacenc::config::Encoder::default().into_verified().map_err(|e| failed(&e.1.to_string()))?;
    let source = flacenc::source::MemSource::from_samples(&samples, channels, bits, rate);
    let stream = flacenc::encode_with_fixed_block_size(&config, source, config.block_size)
        .map_err(|e| failed(&format!("{e:?}")))?;
    let mut sink = flacenc::bitsink::ByteSink::new();
    stream.write(&mut sink).map_err(|e| failed(&format!("{e:?}")))?;
    Ok(sink.as_slice().to_vec())
}

fn wav(samples: &[f32], channels: usize, rate: u32) -> hound::Result<Vec<u8>> {
    let spec = WavSpec {
        channels: channels as u16,
        sample_rate: rate,
        bits_per_sample: 32,
        sample_format: SampleFormat::Float,
    };
    let mut file = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut file, spec)?;
    for x in samples {
        writer.write_sample(*x)?;
    }
    writer.finalize()?;
    let mut bytes = file.into_inner();
    if channels > 2 {
        // no loudspeakers: see `ca_io::sound`
        bytes[40..44].fill(0);
    }
    Ok(bytes)
}
