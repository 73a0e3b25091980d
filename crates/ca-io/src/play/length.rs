//! Length of a play, and detection of the end of a sound.
//!
//! A MIDI file is played to its last event and until the sound has died away, whatever length the model gives for its
//! own gesture. The decay time is not known in advance, so it is detected in the sound. It is bounded, since a sound
//! may never end.

use crate::level_and_fade::QUIET;
use crate::perform::{Performance, frames, seconds};

/// Time for which a sound must be quiet before it ends \[s\]: longer than beats and the longest audible period.
const HOLD: f64 = 0.5;

/// Length of a play.
#[derive(Clone, Debug, PartialEq)]
pub struct Length {
    /// Largest number of samples.
    pub frames: u64,
    fading: Option<Fading>,
}

/// State of the detection of the end of a sound.
#[derive(Clone, Debug, PartialEq)]
struct Fading {
    /// Samples up to the last event, and samples that must be quiet.
    last: u64,
    hold: u64,
    peak: f64,
    /// Samples so far, and how many of the latest were quiet.
    heard: u64,
    quiet: u64,
}

impl From<u64> for Length {
    fn from(frames: u64) -> Length {
        Length { frames, fading: None }
    }
}

impl Length {
    /// Returns the length as asked \[s\], or else the length given by the gesture and the model.
    pub fn of(p: &Performance, asked: Option<f64>) -> Length {
        let samples = |s: f64| (s * p.scene.rate).ceil() as u64;
        let fading = p.midi_ends().filter(|_| asked.is_none()).map(|end| Fading {
            last: samples(end),
            hold: samples(HOLD),
            peak: 0.0,
            heard: 0,
            quiet: 0,
        });
        Length { frames: frames(p.scene, seconds(p, asked)), fading }
    }

    /// Examines rows of `n_out` numbers, whose first `channels` are sound. Returns false when the play is over:
    /// after the last event of a MIDI file, once the sound has been 60 dB below its peak for half a second.
    pub fn add_rows(&mut self, rows: &[f64], n_out: usize, channels: usize) -> bool {
        let Some(f) = &mut self.fading else { return true };
        for row in rows.chunks_exact(n_out.max(1)) {
            let loud = row.iter().take(channels).fold(0.0_f64, |m, x| m.max(x.abs()));
            f.peak = f.peak.max(loud);
            f.quiet = if loud <= QUIET * f.peak { f.quiet + 1 } else { 0 };
            f.heard += 1;
        }
        f.quiet < f.hold || f.heard < f.last + f.hold
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sound_ends_once_it_is_quiet_long_enough_after_the_last_event() {
        let fading = Fading { last: 10, hold: 4, peak: 0.0, heard: 0, quiet: 0 };
        let mut length = Length { frames: 1000, fading: Some(fading) };
        // a probe beside the sound is ignored
        let mut hear = |x: f64| length.add_rows(&[x, 9.0], 2, 1);
        assert!(hear(-1.0));
        assert!((0..12).all(|_| hear(0.001)), "the last event is at 10");
        assert!(hear(0.0011) && (0..3).all(|_| hear(1e-4)));
        assert!(!hear(1e-4));
        let mut fixed = Length::from(3);
        assert!((0..9).all(|_| fixed.add_rows(&[0.0], 1, 1)));
    }
}
