//! Sound in: a recording that a model is compared with.
//!
//! A WAV recording is read by the code that reads WAV gestures: full scale is 1, integers of every width and
//! floats of 32 and 64 bits are taken, a sample without a value is refused with its place. FLAC is read too. A recording keeps its own rate; nothing is resampled, since a
//! model can be compiled at any rate and a filter would stand between the two.

mod flac;

use crate::error::{FileError, FileErrorKind};
use crate::gesture::{GestureFormat, wav};
use crate::reading;
use std::path::Path;

/// A sound as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// \[Hz\]
    pub rate: f64,
    /// samples of each channel, all of one length
    pub channels: Vec<Vec<f64>>,
}

impl Recording {
    /// Reads a WAV or FLAC file.
    ///
    /// # Errors
    /// If it cannot be read, is neither, or holds a sample without a value.
    pub fn open(path: impl AsRef<Path>) -> Result<Recording, FileError> {
        let path = path.as_ref();
        let is_flac = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("flac"));
        if !is_flac && GestureFormat::of(path) != Some(GestureFormat::Wav) {
            let e = FileError::new(FileErrorKind::Unsupported, "a recording is read from a WAV or FLAC file");
            return Err(e.file(path.display()).fix("save it as `.wav` or `.flac`"));
        }
        let bytes = reading::bytes(path, reading::GESTURE)?;
        let read = if is_flac { flac::channels } else { wav::channels };
        let (rate, channels) = read(&bytes).map_err(|e| e.file(path.display()))?;
        Ok(Recording { rate, channels })
    }
}
