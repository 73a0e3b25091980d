//! Sound in: recordings that a model is compared with.
//!
//! WAV and FLAC files are read. WAV uses the reader of WAV gestures: full scale is 1, integers of all widths and floats
//! of 32 and 64 bits are read, and a sample without a value is an error with its place. A recording keeps its own rate.
//! It is not resampled, because a model can be compiled at any rate and a resampling filter would colour the
//! comparison.

mod flac;

use crate::error::{FileError, FileErrorKind};
use crate::gesture::{GestureFormat, wav};
use crate::read_limited;
use std::path::Path;

/// A recorded sound.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Sample rate \[Hz\].
    pub rate: f64,
    /// Samples of each channel, all of the same length.
    pub channels: Vec<Vec<f64>>,
}

impl Recording {
    /// Reads a WAV or FLAC file.
    ///
    /// # Errors
    /// If the file cannot be read, is neither WAV nor FLAC, or contains a sample without a value.
    pub fn open(path: impl AsRef<Path>) -> Result<Recording, FileError> {
        let path = path.as_ref();
        let is_flac = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("flac"));
        if !is_flac && GestureFormat::of(path) != Some(GestureFormat::Wav) {
            let e = FileError::new(FileErrorKind::Unsupported, "a recording must be a WAV or FLAC file");
            return Err(e.file(path.display()).fix("save it as `.wav` or `.flac`"));
        }
        let bytes = read_limited::bytes(path, read_limited::GESTURE)?;
        let read = if is_flac { flac::channels } else { wav::channels };
        let (rate, channels) = read(&bytes).map_err(|e| e.file(path.display()))?;
        Ok(Recording { rate, channels })
    }
}
