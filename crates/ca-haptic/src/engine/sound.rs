//! Limits the sound to full scale and fades it in after a load (H16), and fades it out after a divergence (H15).

/// The last stage of the sound.
pub(super) struct PeakLimit {
    last: Vec<f64>,
    rise: f64,
    gain: f64,
    fall: f64,
    rest: f64,
}

/// Fade-in after a load \[s\].
const RISE: f64 = 0.05;
/// Fade-out after a divergence \[s\]. With the frame that detects the divergence, it is below the 5 ms of H15.
const FALL: f64 = 0.004;

impl PeakLimit {
    pub(super) fn new(channels: usize, rate: f64) -> PeakLimit {
        PeakLimit {
            last: vec![0.0; channels],
            rise: 1.0 / (RISE * rate),
            gain: 0.0,
            fall: 1.0 / (FALL * rate),
            rest: 1.0,
        }
    }

    /// Processes a sample of each channel. Returns how many were cut. After `diverged`, the last sample fades out.
    pub(super) fn pass(&mut self, frame: &mut [f64], diverged: bool) -> u64 {
        if diverged {
            self.rest = (self.rest - self.fall).max(0.0);
            for (x, last) in frame.iter_mut().zip(&self.last) {
                *x = last * self.rest;
            }
            return 0;
        }
        let mut cut = 0;
        self.gain = (self.gain + self.rise).min(1.0);
        for (x, last) in frame.iter_mut().zip(&mut self.last) {
            let y = if x.is_finite() { *x * self.gain } else { 0.0 };
            *last = y.clamp(-1.0, 1.0);
            cut += u64::from(!x.is_finite() || *last != y);
            *x = *last;
        }
        cut
    }

    pub(super) fn reset(&mut self) {
        (self.gain, self.rest) = (0.0, 1.0);
        self.last.fill(0.0);
    }
}
