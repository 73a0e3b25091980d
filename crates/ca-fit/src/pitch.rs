//! Pitches of the recording and of the model, at the start and at the end of a fit.
//!
//! A pitch is the inverse of the period after which a sound repeats best, by its autocorrelation; the lowest partial
//! may be faint or missing. A sound that hardly repeats, such as a bell or noise, gives `None`.

use super::target::{Samples, mixed, onset};
use ca_report::Hann;
use realfft::RealFftPlanner;

/// Length of the analysed sound, and its start after the onset \[s\].
const WINDOW: f64 = 0.25;
const AFTER: f64 = 0.02;
/// Shortest sound that is analysed \[s\].
const LEAST: f64 = 0.05;
/// Lowest pitch \[Hz\].
const LOWEST: f64 = 25.0;
/// Least autocorrelation of a periodic sound, relative to its power.
const CLEAR: f64 = 0.5;
/// A period counts as equal if its autocorrelation is at most this much less than the best.
const AS_WELL: f64 = 0.1;
/// A semitone, plus the error of a pitch from a short sound \[cents\].
const SEMITONE: f64 = 105.0;
/// A model that ends farther from the recording is in another minimum \[cents\].
const SAME: f64 = 50.0;

struct Period {
    correlation: Vec<f64>,
    rate: f64,
    /// \[Hz\]
    f: f64,
    /// Autocorrelation at the period.
    clear: f64,
}

impl Period {
    fn of(sound: &Samples, rate: f64) -> Option<Period> {
        let begin = onset(sound, rate)? + (AFTER * rate) as usize;
        let one = mixed(sound).pop()?;
        let sound = one.get(begin..)?;
        let length = sound.len().min((WINDOW * rate) as usize);
        if (length as f64) < LEAST * rate {
            return None;
        }
        let mean = sound[..length].iter().sum::<f64>() / length as f64;
        let still: Vec<f64> = sound[..length].iter().map(|x| x - mean).collect();
        let mut windows = Hann::new(length, (2 * length).next_power_of_two());
        // the autocorrelation of the window is divided out (Boersma 1993)
        let (own, of_window) = (products(&mut windows, &still)?, products(&mut windows, &vec![1.0; length])?);
        if own[0] <= 0.0 {
            return None;
        }
        let longest = (length / 2).min((rate / LOWEST) as usize);
        let correlation: Vec<f64> = (0..longest).map(|k| own[k] / own[0] * of_window[0] / of_window[k]).collect();
        // after the descent from delay 0
        let first = (1..longest.checked_sub(2)?).find(|k| correlation[k + 1] > correlation[*k])?;
        let peak = |k: &usize| correlation[*k] >= correlation[k - 1] && correlation[*k] >= correlation[k + 1];
        let peaks: Vec<usize> = (first..longest - 1).filter(peak).collect();
        let best = peaks.iter().map(|k| correlation[*k]).fold(0.0, f64::max);
        let at = peaks.into_iter().find(|k| correlation[*k] >= best - AS_WELL).filter(|_| best >= CLEAR)?;
        let [l, m, r] = [at - 1, at, at + 1].map(|k| correlation[k]);
        let bend = l - 2.0 * m + r;
        let lag = at as f64 + if bend < 0.0 { 0.5 * (l - r) / bend } else { 0.0 };
        Some(Period { rate, f: rate / lag, clear: m, correlation })
    }

    /// Returns whether the sound repeats about as well within a semitone of `f`.
    fn repeats(&self, f: f64) -> bool {
        let semitone = libm::exp2(SEMITONE / 1200.0);
        let from = (self.rate / (f * semitone)) as usize;
        let to = ((self.rate * semitone / f) as usize + 2).min(self.correlation.len());
        let near = self.correlation.get(from..to).unwrap_or_default();
        near.iter().copied().fold(0.0, f64::max) >= self.clear - 1.5 * AS_WELL
    }

    /// Interval up to another period \[cents\].
    fn up_to(&self, other: &Period) -> f64 {
        let cents = 1200.0 * libm::log2(other.f / self.f);
        let ratio = libm::exp2(cents.abs() / 1200.0);
        let multiple = libm::round(ratio);
        // with faint odd partials a sound repeats as well after half of its period, and either octave may be found
        let octave = multiple >= 2.0 && 1200.0 * libm::log2(ratio / multiple).abs() < SEMITONE;
        if octave && self.repeats(other.f) && other.repeats(self.f) { 0.0 } else { cents }
    }
}

/// Autocorrelation of a windowed sound, by delay.
fn products(windows: &mut Hann, sound: &[f64]) -> Option<Vec<f64>> {
    let mut powers = Vec::new();
    windows.powers(sound, 0, &mut powers);
    let back = RealFftPlanner::new().plan_fft_inverse(windows.size());
    let mut spectrum = back.make_input_vec();
    spectrum.iter_mut().zip(&powers).for_each(|(to, p)| to.re = *p);
    let mut found = back.make_output_vec();
    back.process(&mut spectrum, &mut found).ok()?;
    Some(found)
}

/// Pitches \[Hz\]; `None` for a sound that hardly repeats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pitch {
    /// Of the recording.
    pub recording: Option<f64>,
    /// Of the model with its initial values.
    pub start: Option<f64>,
    /// Of the model with the values found.
    pub found: Option<f64>,
    /// From the initial model up to the recording \[cents\].
    pub from_start: f64,
    /// From the fitted model up to the recording \[cents\].
    pub left: f64,
}

impl Pitch {
    /// Measures the recording and the model at both ends of the fit.
    pub(super) fn of(recording: &Samples, start: &Samples, found: &Samples, rate: f64) -> Pitch {
        let [recording, start, found] = [recording, start, found].map(|s| Period::of(s, rate));
        let up = |p: &Option<Period>| p.as_ref().zip(recording.as_ref()).map_or(0.0, |(p, r)| p.up_to(r));
        let hertz = |p: &Option<Period>| p.as_ref().map(|p| p.f);
        Pitch {
            from_start: up(&start),
            left: up(&found),
            recording: hertz(&recording),
            start: hertz(&start),
            found: hertz(&found),
        }
    }

    /// Returns whether the start is more than a semitone from the recording.
    pub fn starts_far(&self) -> bool {
        self.from_start.abs() > SEMITONE
    }

    /// Returns whether the model ends at another pitch than the recording.
    pub fn ends_elsewhere(&self) -> bool {
        self.left.abs() > SAME
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f64 = 48_000.0;

    /// Plucked string; `amplitude` gives each partial `n`.
    fn plucked(f: f64, amplitude: impl Fn(f64) -> f64) -> Samples {
        let at = |i: usize| {
            let t = i as f64 / RATE;
            let partial = |n: i32| {
                let n = f64::from(n);
                amplitude(n) * (-t * (1.0 + 0.3 * n)).exp() * (std::f64::consts::TAU * f * n * t).sin()
            };
            (1..16).map(partial).sum()
        };
        vec![(0..24_000).map(at).collect()]
    }

    #[test]
    fn strings_have_a_pitch_whatever_their_partials() {
        let of = |f: f64, amplitude: &dyn Fn(f64) -> f64| Period::of(&plucked(f, amplitude), RATE).unwrap();
        let bright = |n: f64| 1.0 / n;
        let dull = |n: f64| 1.0 / (n * n * n);
        let hollow = |n: f64| if n == 1.0 { 0.0 } else { 1.0 / n };
        for f in [55.0, 82.4, 110.0, 329.6, 880.0] {
            for shape in [&bright as &dyn Fn(f64) -> f64, &dull, &hollow] {
                let found = of(f, shape);
                assert!((1200.0 * (found.f / f).log2()).abs() < 10.0, "{f}: {}", found.f);
                assert!(found.up_to(&of(f, &bright)).abs() < 10.0);
            }
        }
        // a twelfth and an octave are far, although the long period is a multiple of the short one; a semitone is not
        let (low, high) = (of(110.0, &bright), of(330.0, &bright));
        assert!((low.up_to(&high) - 1901.96).abs() < 20.0 && (high.up_to(&low) + 1901.96).abs() < 20.0);
        assert!((of(110.0, &bright).up_to(&of(220.0, &bright)) - 1200.0).abs() < 20.0);
        assert!(low.up_to(&of(116.5, &bright)) < SEMITONE && low.up_to(&of(118.0, &bright)) > SEMITONE);
        // with faint odd partials, either octave may be found
        let odd = |n: f64| if n % 2.0 == 0.0 { 1.0 / n } else { 0.01 / n };
        assert!(of(110.0, &odd).up_to(&of(220.0, &bright)).abs() < 1.0);
    }

    #[test]
    fn what_does_not_repeat_has_no_pitch() {
        let mut seed = 1_u64;
        let mut next = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        assert!(Period::of(&vec![(0..24_000).map(|_| next()).collect()], RATE).is_none());
        assert!(Period::of(&vec![vec![0.0; 24_000]], RATE).is_none());
        assert!(Period::of(&vec![vec![0.5; 24_000]], RATE).is_none());
        assert!(Period::of(&vec![vec![0.5; 10]], RATE).is_none());
        let none = Pitch::of(&vec![vec![0.0; 9]], &plucked(110.0, |n| 1.0 / n), &vec![Vec::new()], RATE);
        assert!(!none.starts_far() && !none.ends_elsewhere());
    }
}
