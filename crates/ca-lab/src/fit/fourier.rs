//! Windows of a sound and their powers.

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};
use std::sync::Arc;

/// Windows of one length, padded with zeros to another.
pub(super) struct Windows {
    /// samples of a window
    pub length: usize,
    /// samples of a transform
    pub size: usize,
    hann: Vec<f64>,
    transform: Arc<dyn RealToComplex<f64>>,
    room: Vec<f64>,
    bins: Vec<Complex<f64>>,
}

impl Windows {
    /// Windows by Hann, whose powers are those of a sine of amplitude 1.
    pub fn new(length: usize, size: usize) -> Windows {
        let transform = RealFftPlanner::new().plan_fft_forward(size);
        let turn = std::f64::consts::TAU / length as f64;
        let hann = (0..length).map(|i| (1.0 - libm::cos(turn * (i as f64 + 0.5))) / length as f64).collect();
        let (room, bins) = (transform.make_input_vec(), transform.make_output_vec());
        Windows { length, size, hann, transform, room, bins }
    }

    /// The powers of the window that begins here, bin by bin; what is beyond the sound is silence.
    pub fn powers(&mut self, sound: &[f64], begin: usize, powers: &mut Vec<f64>) {
        let there = sound.get(begin..).unwrap_or(&[]);
        self.room.fill(0.0);
        for ((to, x), w) in self.room.iter_mut().zip(there).zip(&self.hann) {
            *to = x * w;
        }
        powers.clear();
        // lengths are those that were planned
        if self.transform.process(&mut self.room, &mut self.bins).is_ok() {
            powers.extend(self.bins.iter().map(Complex::norm_sqr));
        }
    }
}
