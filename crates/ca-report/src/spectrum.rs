//! Spectrum of a sound, in levels of sines.
//!
//! A sine at full scale reads 0 dB at any frequency. Hann windows are scaled by their sum and transforms are at least
//! twice as long as the window, so a sine between two bins reads at most 0.4 dB less. A sound longer than a window is
//! cut into windows that overlap by half, and their powers are averaged. The plot has columns of equal ratios; each
//! shows its loudest bin, at the frequency of that bin.

use crate::plot::{Axis, Curve, Grid, Mark, Plot};
use crate::sound::{CHANNELS, Sound};
use realfft::RealFftPlanner;

/// Longest window: bins 0.37 Hz apart at 48 kHz, before padding.
const WINDOW: usize = 1 << 17;
const COLUMNS: usize = 1500;
/// Lowest frequency shown, about the lowest audible pitch \[Hz\].
pub const LOWEST: f64 = 20.0;
/// Range of levels below the loudest \[dB\].
const DEPTH: f64 = 120.0;

/// Hann window with its transform.
pub struct Hann {
    window: Vec<f64>,
    size: usize,
    fft: std::sync::Arc<dyn realfft::RealToComplex<f64>>,
    input: Vec<f64>,
    output: Vec<realfft::num_complex::Complex<f64>>,
}

impl Hann {
    /// Makes a window of `n` samples for a transform of `size` samples, at least `n`.
    pub fn new(n: usize, size: usize) -> Hann {
        let turn = std::f64::consts::TAU / n.max(1) as f64;
        // scaled so that a sine of amplitude A has a quarter of A² at its bin
        let window = (0..n).map(|i| (1.0 - libm::cos(turn * (i as f64 + 0.5))) / n as f64).collect();
        let fft = RealFftPlanner::new().plan_fft_forward(size);
        let (input, output) = (fft.make_input_vec(), fft.make_output_vec());
        Hann { window, size, fft, input, output }
    }

    /// Returns the length of the window in samples.
    pub fn length(&self) -> usize {
        self.window.len()
    }

    /// Returns the length of the transform in samples.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Adds the power of each bin to `power`; a sine of amplitude A has A² at its bin. The window begins at sample
    /// `start`, which may be negative; samples outside the sound are 0.
    pub fn add(&mut self, sound: &[f64], start: isize, power: &mut [f64]) {
        let (missing, first) = (start.min(0).unsigned_abs(), start.max(0).unsigned_abs());
        let there = sound.get(first..).unwrap_or_default();
        self.input.fill(0.0);
        let from = self.input.iter_mut().zip(&self.window).skip(missing);
        from.zip(there).for_each(|((to, w), x)| *to = w * x);
        let done = self.fft.process(&mut self.input, &mut self.output);
        debug_assert!(done.is_ok(), "the buffers are its own");
        power.iter_mut().zip(&self.output).for_each(|(p, c)| *p += 4.0 * c.norm_sqr());
    }

    /// Sets `power` to the powers of the window that begins at sample `start`.
    pub fn powers(&mut self, sound: &[f64], start: usize, power: &mut Vec<f64>) {
        power.clear();
        power.resize(self.size / 2 + 1, 0.0);
        self.add(sound, isize::try_from(start).unwrap_or(isize::MAX), power);
    }
}

/// Returns the level of a power \[dB\], −∞ for 0.
pub(crate) fn decibel(power: f64) -> f64 {
    10.0 * power.log10()
}

/// Spectrum of all channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Distance of bins \[Hz\].
    pub step: f64,
    /// Power of each channel, bin by bin, from 0 Hz; a sine of amplitude A has A² at its bin.
    pub power: Vec<Vec<f64>>,
}

impl Spectrum {
    /// Computes the spectrum of the stored part of a sound; `None` for an empty sound.
    pub fn of(sound: &Sound) -> Option<Spectrum> {
        let channels: Vec<Vec<f64>> = (0..sound.names().len().min(CHANNELS)).map(|k| sound.channel(k)).collect();
        let n = channels.first().map_or(0, Vec::len);
        if n == 0 {
            return None;
        }
        let window = n.min(WINDOW);
        let size = (2 * window).next_power_of_two();
        let mut hann = Hann::new(window, size);
        let windows = 1 + (n - window).div_ceil(window / 2 + 1);
        let hop = (n - window) as f64 / (windows - 1).max(1) as f64;
        let power = channels.iter().map(|samples| {
            let mut power = vec![0.0; size / 2 + 1];
            (0..windows).for_each(|i| hann.add(samples, (i as f64 * hop) as isize, &mut power));
            for p in &mut power {
                *p /= windows as f64;
            }
            power
        });
        Some(Spectrum { step: sound.rate() / size as f64, power: power.collect() })
    }

    /// Returns the plot, with marks at frequencies \[Hz\]; `None` for silence.
    pub fn plot(&self, names: &[String], marks: Vec<Mark>) -> Option<Plot> {
        let top = self.power.iter().flatten().copied().fold(0.0, f64::max);
        let highest = self.step * self.power.first()?.len() as f64;
        if top == 0.0 || highest <= LOWEST {
            return None;
        }
        let ratio = (highest / LOWEST).powf(1.0 / COLUMNS as f64);
        let (mut x, mut y) = (Vec::new(), vec![Vec::new(); self.power.len()]);
        let mut bin = (LOWEST / self.step).ceil() as usize;
        for column in 1..=COLUMNS {
            let end = ((LOWEST * ratio.powi(column as i32) / self.step) as usize).min(self.power[0].len());
            if bin >= end {
                continue;
            }
            let loudest = |p: &[f64]| p[bin..end].iter().copied().fold(0.0, f64::max);
            let sum = |i: usize| self.power.iter().map(|p| p[i]).sum::<f64>();
            let at = (bin..end).max_by(|a, b| sum(*a).total_cmp(&sum(*b))).unwrap_or(bin);
            x.push(at as f64 * self.step);
            y.iter_mut().zip(&self.power).for_each(|(y, p)| y.push(decibel(loudest(p))));
            bin = end;
        }
        let top = decibel(top);
        // levels far below the loudest are rounding
        y.iter_mut().flatten().for_each(|v| *v = v.max(top - DEPTH));
        Some(Plot {
            title: "Spectrum".into(),
            x: Axis::log("frequency", "Hz").over(LOWEST, highest),
            y: Axis::linear("level of a sine", "dBFS").over(top - DEPTH, top + 6.0),
            grid: Grid::Points(x),
            curves: names.iter().zip(y).map(|(name, y)| Curve::line(name, y)).collect(),
            marks,
            image: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(seconds: f64, f: f64, level: f64) -> Sound {
        let mut s = Sound::new(48_000.0, &["out".into()]);
        let n = (seconds * 48_000.0) as usize;
        s.push(&(0..n).map(|i| level * (TAU * f * i as f64 / 48_000.0).sin()).collect::<Vec<_>>());
        s
    }

    /// Bin and level are right for lengths of one window and of several, on bins and between them.
    #[test]
    fn a_sine_stands_where_it_is_and_reads_its_level() {
        for seconds in [0.1, 1.0, 2.7, 9.3] {
            for (f, level) in [(440.0, 1.0), (997.13, 0.1), (17_000.7, 0.5), (55.05, 1e-4)] {
                let s = Spectrum::of(&sine(seconds, f, level)).unwrap();
                let bin = (0..s.power[0].len()).max_by(|a, b| s.power[0][*a].total_cmp(&s.power[0][*b])).unwrap();
                let off = bin as f64 * s.step - f;
                // the image at negative frequency biases a low sine in a short window
                let wide = if seconds * f < 20.0 { 2.0 } else { 0.51 };
                assert!(off.abs() <= wide * s.step, "{f} Hz in {seconds} s stands {off} Hz away, bins {}", s.step);
                let (is, want) = (decibel(s.power[0][bin]), 20.0 * level.log10());
                assert!((-0.45..=0.05).contains(&(is - want)), "{f} Hz in {seconds} s reads {is} dB, not {want}");
            }
        }
    }

    #[test]
    fn the_plot_shows_the_peak_and_bounds_its_size() {
        let s = Spectrum::of(&sine(4.0, 1234.5, 0.25)).unwrap();
        let plot = s.plot(&["out".into()], Vec::new()).unwrap();
        let Grid::Points(x) = &plot.grid else { panic!("frequencies") };
        assert!(x.len() <= COLUMNS && x.windows(2).all(|w| w[0] < w[1]) && x[0] >= LOWEST);
        let y = &plot.curves[0].y;
        let top = (0..y.len()).max_by(|a, b| y[*a].total_cmp(&y[*b])).unwrap();
        assert!((x[top] - 1234.5).abs() < s.step && (y[top] + 12.04).abs() < 0.45, "{} {}", x[top], y[top]);
        assert!(y.iter().all(|v| v.is_finite()));
    }

    #[test]
    fn silence_and_one_sample_have_no_curve_or_one() {
        assert!(Spectrum::of(&Sound::new(48_000.0, &["out".into()])).is_none());
        let quiet = Spectrum::of(&sine(0.5, 100.0, 0.0)).unwrap();
        assert!(quiet.plot(&["out".into()], Vec::new()).is_none());
        let mut click = Sound::new(48_000.0, &["out".into()]);
        click.push(&[1.0]);
        let s = Spectrum::of(&click).unwrap();
        assert!(s.plot(&["out".into()], Vec::new()).is_none_or(|p| !p.is_empty()));
    }
}
