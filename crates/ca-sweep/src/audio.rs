//! The sound of a run as the bytes of a file.
//!
//! Decides for whole files in memory: a run is short, and it appears with its fellows or not at all (`folder.rs`).

use ca_io::flac;
use ca_io::format::Format;
use ca_io::sound;
use ca_lab::Failure;

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
        match self {
            Audio::Flac => {
                flac::refuses(channels, rate).map(|why| format!("{why}; \"wav\" holds more, \"none\" keeps rows only"))
            }
            Audio::Wav => {
                let fits = (1..=256).contains(&channels) && rate.fract() == 0.0 && (1.0..=1e6).contains(&rate);
                let what = "WAV holds 1 to 256 channels at whole rates up to 1000000 Hz";
                (!fits).then(|| format!("{what}, not {channels} at {rate}; \"none\" keeps rows only"))
            }
            Audio::None => None,
        }
    }

    /// The bytes of a file; none for [`Audio::None`]. Interleaved samples within ±1, whole frames.
    ///
    /// # Errors
    /// [`Failure::Failed`] where the encoder takes none of it.
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
