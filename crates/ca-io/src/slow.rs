//! What of a sound is too slow to be heard: a body that drifts fills an output, and nothing of it sounds.

/// Below this nothing is heard \[Hz\].
pub const EDGE: f64 = 5.0;
/// A sound of less power has no slow part worth a word.
const NOTHING: f64 = 1e-20;

/// Of a sound that is heard block by block: the power of each channel, and that of what two low-passes of one pole, 3 dB down together at [`EDGE`], leave of it.
#[derive(Clone, Debug)]
pub struct Slow {
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

impl Slow {
    /// Of so many channels at `rate` \[Hz\].
    pub fn new(channels: usize, rate: f64) -> Slow {
        // two poles at w are 3 dB down at w·sqrt(sqrt 2 − 1)
        let corner = EDGE / (2.0_f64.sqrt() - 1.0).sqrt();
        let pole = 1.0 - (-2.0 * std::f64::consts::PI * corner / rate).exp();
        Slow { pole, channels: vec![Channel::default(); channels] }
    }

    /// Hears whole frames, interleaved.
    pub fn hear(&mut self, frames: &[f64]) {
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

    /// The channels of which more than half of the power is too slow, with its share.
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
            let mut s = Slow::new(2, rate);
            let frames: Vec<f64> = (0..96_000).flat_map(|n| [sine(ask, n), sine(330.0, n)]).collect();
            s.hear(&frames);
            let found: Vec<usize> = s.found().map(|f| f.0).collect();
            assert_eq!(found, if slow { vec![0] } else { vec![] }, "{name}");
        }
    }
}
