//! Measures of the sound of a run.

use ca_model::quantity::six;
use ca_report::pitch::{fall, partial, spectrum};

/// Samples per point of the decay.
const BLOCK: usize = 256;
/// Depth below the loudest point to which the decay is followed \[dB\].
const DEPTH: f64 = 60.0;

/// Measures of a sound.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Strongest partial of the loudest channel \[Hz\].
    pub partial: Option<f64>,
    /// Time in which the sound falls by 60 dB \[s\].
    pub t60: Option<f64>,
}

/// Root mean square of all samples.
pub fn rms(samples: &[f32]) -> f64 {
    if samples.is_empty() {
        return 0.0;
    }
    (samples.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
}

/// Measures interleaved samples.
pub fn measures(samples: &[f32], channels: usize, rate: f64) -> Measures {
    let power = |k: usize| samples.iter().skip(k).step_by(channels).map(|x| f64::from(*x).powi(2)).sum::<f64>();
    let loudest = (0..channels).max_by(|a, b| power(*a).total_cmp(&power(*b)));
    let Some(loudest) = loudest.filter(|k| power(*k) > 0.0) else { return Measures::default() };
    let column: Vec<f64> = samples.iter().skip(loudest).step_by(channels).map(|x| f64::from(*x)).collect();
    // rounded, since the last bits of transforms differ from machine to machine
    let partial = spectrum(&column, rate).as_ref().and_then(partial).map(six);
    Measures { partial, t60: t60(samples, channels, rate) }
}

/// Returns the decay time by a line through the levels of blocks \[dB\], from the loudest until 60 dB below it or the
/// end of the sound. This is exact for an exponential decay of any length. `None` where the sound does not decay.
fn t60(samples: &[f32], channels: usize, rate: f64) -> Option<f64> {
    let blocks = samples.chunks_exact(BLOCK * channels);
    let level = |b: &[f32]| 10.0 * libm::log10(b.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>());
    let levels: Vec<f64> = blocks.map(level).collect();
    let (slope, points) = fall(&levels, DEPTH)?;
    let seconds = -DEPTH / slope * BLOCK as f64 / rate;
    // a fall of less than 0.01 dB over the whole sound is not a decay
    (points >= 4 && slope * (points as f64) < -0.01).then_some(seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decaying(f: f64, t60: f64, seconds: f64, rate: f64) -> Vec<f32> {
        let fall = 1000f64.ln() / t60;
        let n = (seconds * rate) as usize;
        let at = |k: usize| k as f64 / rate;
        (0..n).map(|k| (0.5 * (-fall * at(k)).exp() * (std::f64::consts::TAU * f * at(k)).sin()) as f32).collect()
    }

    #[test]
    fn a_decaying_sine_has_its_pitch_and_its_decay() {
        for (f, t60, seconds) in [(440.0, 0.5, 1.0), (220.0, 3.0, 1.0), (1234.5, 0.1, 0.7), (97.0, 20.0, 2.0)] {
            let m = measures(&decaying(f, t60, seconds, 48e3), 1, 48e3);
            let (pitch, decay) = (m.partial.unwrap(), m.t60.unwrap());
            // decay widens a partial
            assert!((pitch - f).abs() < 0.02 / t60 + 0.02, "{f} Hz: {pitch}");
            assert!((decay / t60 - 1.0).abs() < 0.02, "{t60} s: {decay}");
        }
    }

    #[test]
    fn the_loudest_channel_is_heard() {
        let (a, b) = (decaying(300.0, 1.0, 0.5, 48e3), decaying(500.0, 1.0, 0.5, 48e3));
        let both: Vec<f32> = a.iter().zip(&b).flat_map(|(a, b)| [0.1 * a, *b]).collect();
        let m = measures(&both, 2, 48e3);
        assert!((m.partial.unwrap() - 500.0).abs() < 0.1, "{m:?}");
        assert!((m.t60.unwrap() - 1.0).abs() < 0.02, "{m:?}");
    }

    #[test]
    fn silence_and_what_goes_on_have_none() {
        assert_eq!(measures(&vec![0.0; 9600], 2, 48e3), Measures::default());
        assert_eq!(measures(&[], 1, 48e3), Measures::default());
        let steady: Vec<f32> = (0..48_000).map(|k| (0.1 * f64::from(k)).sin() as f32).collect();
        let m = measures(&steady, 1, 48e3);
        assert!(m.t60.is_none() && m.partial.is_some(), "{m:?}");
        // the pitch of a drift is not below the audible range
        let drift: Vec<f32> = (0..960).map(|k| (k as f32 / 960.0).powi(2)).collect();
        assert!(measures(&drift, 1, 48e3).partial.is_none_or(|f| f >= ca_report::LOWEST));
        assert_eq!(rms(&[]), 0.0);
        assert!((rms(&steady) - 0.5f64.sqrt()).abs() < 1e-4);
    }
}
