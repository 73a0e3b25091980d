//! Encodes the sound of a run in memory: a run is short, and its chunk appears whole or not at all (`folder.rs`).

use ca_io::flac;
use ca_io::format::Format;
use ca_io::sound;
use ca_lab::Failure;

/// Format of sound files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audio {
    /// FLAC with 24 bits, about half the size.
    Flac,
    /// WAV with 32-bit floats.
    Wav,
    /// No sound files.
    None,
}

impl Audio {
    /// Returns the format of this name.
    pub fn named(name: &str) -> Option<Audio> {
        [Audio::Flac, Audio::Wav, Audio::None].into_iter().find(|a| a.name() == name)
    }

    /// Name of the format, which is also the extension of its files.
    pub fn name(self) -> &'static str {
        match self {
            Audio::Flac => "flac",
            Audio::Wav => "wav",
            Audio::None => "none",
        }
    }

    /// Returns the reason why the format cannot hold sounds of this shape.
    pub fn refuses(self, channels: usize, rate: f64) -> Option<String> {
        match self {
            Audio::Flac => {
                flac::refuses(channels, rate).map(|why| format!("{why}; use \"wav\", or \"none\" for rows only"))
            }
            Audio::Wav => {
                let fits = (1..=256).contains(&channels) && rate.fract() == 0.0 && (1.0..=1e6).contains(&rate);
                let what = "WAV supports 1 to 256 channels at whole rates up to 1000000 Hz";
                (!fits).then(|| format!("{what}, not {channels} at {rate} Hz; use \"none\" for rows only"))
            }
            Audio::None => None,
        }
    }

    /// Encodes interleaved samples within ±1, in whole frames; the result is empty for [`Audio::None`].
    ///
    /// # Errors
    /// [`Failure::Failed`] where the encoder fails.
    pub fn encode(self, samples: &[f32], channels: usize, rate: f64) -> Result<Vec<u8>, Failure> {
        match self {
            Audio::Flac => {
                flac::encode(samples, channels, rate, Format::I24).map_err(|e| Failure::Failed(e.to_string()))
            }
            Audio::Wav => Ok(sound::floats(samples, channels, rate as u32)),
            Audio::None => Ok(Vec::new()),
        }
    }
}
