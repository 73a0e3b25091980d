//! Where a performance is kept: a sound file, and a take.

use ca_haptic::FileError;
use ca_haptic::record::Record;
use ca_haptic::serve::{Happened, Pulse, Sink};
use ca_haptic::sound::{WavOut, Written};
use ca_haptic::take::{Level, Recorder, Rings, Rt, Told};
use std::cell::RefCell;
use std::rc::Rc;

/// A sink kept by two: the desk writes it, the command finishes it.
pub(super) struct Kept<T>(Rc<RefCell<Option<T>>>);

impl<T> Clone for Kept<T> {
    fn clone(&self) -> Kept<T> {
        Kept(self.0.clone())
    }
}

impl<T> Kept<T> {
    pub(super) fn new(of: T) -> Kept<T> {
        Kept(Rc::new(RefCell::new(Some(of))))
    }

    /// It, once.
    pub(super) fn end(&self) -> Option<T> {
        self.0.borrow_mut().take()
    }

    fn with(&self, f: impl FnOnce(&mut T) -> Result<(), FileError>) -> Result<(), FileError> {
        self.0.borrow_mut().as_mut().map_or(Ok(()), f)
    }
}

/// A WAV file. Sound that was lost is silence there, so that the rest stays where it belongs.
pub(super) struct Wav {
    out: WavOut,
    channels: usize,
    next: u64,
}

impl Wav {
    pub(super) fn new(out: WavOut, channels: usize) -> Wav {
        Wav { out, channels, next: 0 }
    }

    pub(super) fn finish(self) -> Result<Written, FileError> {
        self.out.finish()
    }
}

impl Sink for Kept<Wav> {
    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        self.with(|w| {
            if tick > w.next {
                w.out.write(&vec![0.0; (tick - w.next) as usize * w.channels])?;
            }
            w.next = tick + (frames.len() / w.channels) as u64;
            w.out.write(frames)
        })
    }
}

/// A take, written by its own thread.
pub(super) struct Take {
    recorder: Recorder,
    rings: Rings,
}

impl Take {
    pub(super) fn new((recorder, rings): (Recorder, Rings)) -> Take {
        Take { recorder, rings }
    }

    pub(super) fn finish(self) -> Result<Told, FileError> {
        drop(self.rings);
        self.recorder.finish()
    }
}

impl Sink for Kept<Take> {
    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        self.with(|t| {
            t.rings.record(record.clone());
            Ok(())
        })
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        self.with(|t| {
            t.rings.sound(tick, frames);
            Ok(())
        })
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        self.with(|t| {
            t.rings.view(tick, x);
            Ok(())
        })
    }

    fn pulse(&mut self, p: &Pulse) -> Result<(), FileError> {
        self.with(|t| {
            t.rings.stats(Rt {
                tick: p.tick,
                frames: p.frames,
                missed: p.missed,
                stale: p.stale,
                dropped: p.dropped,
                faults: p.faults,
                clipped: p.clipped,
                late_p50: p.late_us.p50,
                late_p99: p.late_us.p99,
                late_max: p.late_us.max,
                busy: p.load,
                underruns: p.underruns,
                audio_ppm: p.ppm,
            });
            Ok(())
        })
    }

    fn said(&mut self, h: &Happened) -> Result<(), FileError> {
        self.with(|t| {
            // modes and causes of devices are told by the frames themselves
            if h.device.is_none() {
                t.recorder.log(if h.bad { Level::Warning } else { Level::Info }, "serve", &h.text);
            }
            Ok(())
        })
    }
}
