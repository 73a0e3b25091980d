//! Sound in: a recording that a model is compared with.
//!
//! Decides that a recording is read as a WAV gesture is, by the same code: full scale is 1, integers of every width and
//! floats of 32 and 64 bits are taken, a sample without a value is refused with its place. It keeps its own rate; nothing is resampled, since a
//! model can be compiled at any rate and a filter would stand between the two.

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
    /// Reads a WAV file.
    ///
    /// # Errors
    /// Where it cannot be read, is no WAV file, or holds a sample without a value.
    pub fn open(path: impl AsRef<Path>) -> Result<Recording, FileError> {
        let path = path.as_ref();
        if GestureFormat::of(path) != Some(GestureFormat::Wav) {
            let e = FileError::new(FileErrorKind::Unsupported, "a recording is read from a WAV file");
            return Err(e.file(path.display()).fix("save it as `.wav`"));
        }
        let bytes = reading::bytes(path, reading::GESTURE)?;
        let (rate, channels) = wav::channels(&bytes).map_err(|e| e.file(path.display()))?;
        Ok(Recording { rate, channels })
    }
}
