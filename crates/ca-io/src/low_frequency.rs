//! Finds outputs dominated by inaudibly low frequencies, as from a drifting body.

/// Lower edge of audible frequencies \[Hz\].
pub const EDGE: f64 = 5.0;
/// Power below which a sound is not examined.
const NOTHING: f64 = 1e-20;

/// Power of each channel, in total and below [`EDGE`].
///
/// Two one-pole low-passes in series, together 3 dB down at [`EDGE`], extract the slow part. Samples arrive block by
/// block.
#[derive(Clone, Debug)]
pub struct LowFrequencyMeter {
    pole: f64,
    channels: Vec<Channel>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Channel {
    first: f64,
    second: f64,
    slow: f64,
    all: f64,
}

impl LowFrequencyMeter {
    /// Takes the number of channels and the rate \[Hz\].
    pub fn new(channels: usize, rate: f64) -> LowFrequencyMeter {
        // two poles at w are 3 dB down at w·sqrt(sqrt 2 − 1)
        let corner = EDGE / (2.0_f64.sqrt() - 1.0).sqrt();
        let pole = 1.0 - (-2.0 * std::f64::consts::PI * corner / rate).exp();
        LowFrequencyMeter { pole, channels: vec![Channel::default(); channels] }
    }

    /// Adds whole frames, interleaved.
    pub fn add(&mut self, frames: &[f64]) {
        let pole = self.pole;
        for frame in frames.chunks_exact(self.channels.len().max(1)) {
            for (c, x) in self.channels.iter_mut().zip(frame).filter(|(_, x)| x.is_finite()) {
                c.first += pole * (x - c.first);
                c.second += pole * (c.first - c.second);
                c.slow += c.second * c.second;
                c.all += x * x;
            }
        }
    }

    /// Returns the channels with more than half of their power in the slow part, each with that share.
    pub fn found(&self) -> impl Iterator<Item = (usize, f64)> {
        let share = |c: &Channel| if c.all > NOTHING { c.slow / c.all } else { 0.0 };
        self.channels.iter().map(share).enumerate().filter(|(_, share)| *share > 0.5)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_the_power_is_the_border() {
        let rate = 48_000.0;
        let sine = |f: f64, n: usize| (2.0 * std::f64::consts::PI * f * n as f64 / rate).sin();
        for (name, slow, ask) in
            [("a drift", true, 1.0), ("its border", true, 4.0), ("heard", false, 6.5), ("a tone", false, 220.0)]
        {
            let mut s = LowFrequencyMeter::new(2, rate);
            let frames: Vec<f64> = (0..96_000).flat_map(|n| [sine(ask, n), sine(330.0, n)]).collect();
            s.add(&frames);
            let found: Vec<usize> = s.found().map(|f| f.0).collect();
            assert_eq!(found, if slow { vec![0] } else { vec![] }, "{name}");
        }
    }
}
