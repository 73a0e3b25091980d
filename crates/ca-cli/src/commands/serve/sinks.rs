//! The sound file of a performance.

use ca_haptic::FileError;
use ca_haptic::serve::Sink;
use ca_haptic::sound::{WavOut, Written};
use std::cell::RefCell;
use std::rc::Rc;

/// A WAV file, kept by two: the desk writes it, the command finishes it.
#[derive(Clone)]
pub(super) struct Wav(Rc<RefCell<Option<WavOut>>>);

impl Wav {
    pub(super) fn new(out: WavOut) -> Wav {
        Wav(Rc::new(RefCell::new(Some(out))))
    }

    pub(super) fn finish(&self) -> Option<Result<Written, FileError>> {
        self.0.borrow_mut().take().map(WavOut::finish)
    }
}

impl Sink for Wav {
    fn sound(&mut self, frames: &[f64]) -> Result<(), FileError> {
        self.0.borrow_mut().as_mut().map_or(Ok(()), |w| w.write(frames))
    }
}
