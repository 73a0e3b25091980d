//! Acoustic measures: frequency, level, decay and spectrum of a sound, for tests and the page of instruments.
//!
//! The spectrum uses a Gaussian window, because the peak of a decaying sine then is a parabola in decibels. Three
//! points give its frequency to far below a cent.

use realfft::RealFftPlanner;
use std::f64::consts::{LN_10, TAU};

/// Returns the power spectrum through a Gaussian window, and the width of its bins \[Hz\].
fn spectrum(x: &[f64], rate: f64) -> (Vec<f64>, f64) {
    let (n, size) = (x.len() as f64, (4 * x.len()).next_power_of_two());
    let mut buffer = vec![0.0; size];
    for (i, (b, x)) in buffer.iter_mut().zip(x).enumerate() {
        let u = (i as f64 - 0.5 * (n - 1.0)) / (0.125 * n);
        *b = x * (-0.5 * u * u).exp();
    }
    let fft = RealFftPlanner::new().plan_fft_forward(size);
    let mut out = fft.make_output_vec();
    fft.process(&mut buffer, &mut out).unwrap();
    // a sine of amplitude 1 peaks at 1
    let scale = 2.0 / (0.125 * n * TAU.sqrt());
    (out.iter().map(|c| c.norm_sqr() * scale * scale).collect(), rate / size as f64)
}

/// Returns the frequency \[Hz\] and amplitude of the strongest partial within `reach` of `near` \[Hz\].
pub fn partial(x: &[f64], rate: f64, near: f64, reach: f64) -> (f64, f64) {
    let (power, bin) = spectrum(x, rate);
    let (lo, hi) = (((near - reach) / bin).ceil().max(1.0) as usize, ((near + reach) / bin) as usize);
    let top = (lo..=hi.min(power.len() - 2)).max_by(|a, b| power[*a].total_cmp(&power[*b])).unwrap();
    let [a, b, c] = [top - 1, top, top + 1].map(|i| (power[i] + 1e-300).ln());
    let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
    ((top as f64 + offset) * bin, (0.5 * (b - 0.25 * (a - c) * offset)).exp())
}

/// Returns the interval from `b` to `a` in cents.
pub fn cents(a: f64, b: f64) -> f64 {
    1200.0 * (a / b).log2()
}

/// Returns an amplitude in decibels.
pub fn db(a: f64) -> f64 {
    20.0 * a.max(1e-300).log10()
}

/// Returns the root mean square about the mean.
pub fn rms(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (x.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / x.len() as f64).sqrt()
}

/// Returns the largest magnitude.
pub fn peak(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |p, v| p.max(v.abs()))
}

/// Returns the rms in consecutive windows of `len` samples.
pub fn envelope(x: &[f64], len: usize) -> Vec<f64> {
    x.chunks_exact(len).map(rms).collect()
}

/// Returns the time \[s\] in which the partial at `f` \[Hz\] falls by 60 dB.
///
/// The level is measured in overlapping Gaussian windows of a sixth of `x`, and a straight line is fitted to it.
pub fn t60(x: &[f64], rate: f64, f: f64) -> f64 {
    let len = x.len() / 6;
    let points: Vec<[f64; 2]> = (0..=20)
        .map(|i| {
            let start = i * (x.len() - len) / 20;
            let (mut re, mut im) = (0.0, 0.0);
            for (k, v) in x[start..start + len].iter().enumerate() {
                let u = (k as f64 - 0.5 * len as f64) / (0.125 * len as f64);
                let (s, c) = (TAU * f * (start + k) as f64 / rate).sin_cos();
                let w = v * (-0.5 * u * u).exp();
                re += w * c;
                im += w * s;
            }
            [start as f64 / rate, 10.0 * (re * re + im * im).log10()]
        })
        .collect();
    -60.0 / slope(&points)
}

/// Returns the slope of the straight line fitted to points.
pub fn slope(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let (mx, my) = (mean(0), mean(1));
    let over: f64 = points.iter().map(|p| (p[0] - mx) * (p[1] - my)).sum();
    over / points.iter().map(|p| (p[0] - mx) * (p[0] - mx)).sum::<f64>()
}

/// Returns the centre of gravity of the power spectrum \[Hz\].
pub fn centroid(x: &[f64], rate: f64) -> f64 {
    let (power, bin) = spectrum(x, rate);
    let moment: f64 = power.iter().enumerate().map(|(i, p)| i as f64 * bin * p).sum();
    moment / power.iter().sum::<f64>()
}

/// Returns the power spectral density summed over windows of `len` samples, and the width of its bins \[Hz\].
pub fn density(x: &[f64], rate: f64, len: usize) -> (Vec<f64>, f64) {
    let mut sum: Vec<f64> = Vec::new();
    let mut bin = 0.0;
    for start in (0..=x.len() - len).step_by(len / 2) {
        let (power, width) = spectrum(&x[start..start + len], rate);
        bin = width;
        sum.resize(power.len(), 0.0);
        sum.iter_mut().zip(&power).for_each(|(s, p)| *s += p);
    }
    (sum, bin)
}

/// Returns the spectral flatness between two frequencies: 1 for white noise, near 0 for tones.
pub fn flatness(x: &[f64], rate: f64, lo: f64, hi: f64) -> f64 {
    let (d, bin) = density(x, rate, 4096);
    let band = &d[(lo / bin) as usize..(hi / bin) as usize];
    let n = band.len() as f64;
    (band.iter().map(|p| (p + 1e-300).ln()).sum::<f64>() / n).exp() / (band.iter().sum::<f64>() / n)
}

/// Returns the period \[s\] between `lo` and `hi` \[s\] with the largest autocorrelation of `x`, and that correlation
/// (1: exactly periodic).
pub fn period(x: &[f64], rate: f64, lo: f64, hi: f64) -> (f64, f64) {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    let y: Vec<f64> = x.iter().map(|v| v - mean).collect();
    let like = |lag: usize| {
        let n = y.len() - lag;
        let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
        for (a, b) in y[..n].iter().zip(&y[lag..]) {
            xy += a * b;
            xx += a * a;
            yy += b * b;
        }
        xy / (xx * yy).sqrt()
    };
    let lags: Vec<usize> = ((lo * rate) as usize..=(hi * rate) as usize).collect();
    let best = lags.into_iter().max_by(|a, b| like(*a).total_cmp(&like(*b))).unwrap();
    let [a, b, c] = [best - 1, best, best + 1].map(like);
    let bend = a - 2.0 * b + c;
    let offset = if bend < 0.0 { 0.5 * (a - c) / bend } else { 0.0 };
    ((best as f64 + offset) / rate, b)
}

/// Returns the change per second.
pub fn velocity(x: &[f64], rate: f64) -> Vec<f64> {
    x.windows(2).map(|w| (w[1] - w[0]) * rate).collect()
}

/// Returns frequency \[Hz\] and T60 \[s\] at which the scheme plays a mode of stiffness ratio `a` = λT² and damping
/// ratio `b`: the roots of w² − (2 − a − b) w + 1 − b.
pub fn mode(a: f64, b: f64, rate: f64) -> (f64, f64) {
    let r = (1.0 - b).sqrt();
    let theta = ((2.0 - a - b) / (2.0 * r)).acos();
    (theta * rate / TAU, if b > 0.0 { -3.0 * LN_10 / (r.ln() * rate) } else { f64::INFINITY })
}

/// Returns the stiffness ratio at which the scheme plays `f` \[Hz\] with damping ratio `b`.
pub fn stiffness(f: f64, b: f64, rate: f64) -> f64 {
    2.0 - b - 2.0 * (1.0 - b).sqrt() * (TAU * f / rate).cos()
}

/// Returns the damping ratio for a decay of 60 dB in `t60` \[s\].
pub fn damping(t60: f64, rate: f64) -> f64 {
    1.0 - (-6.0 * LN_10 / (t60 * rate)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_measures_measure() {
        let rate = 48_000.0;
        let (a, b) = (stiffness(441.3, damping(1.7, rate), rate), damping(1.7, rate));
        assert!(cents(mode(a, b, rate).0, 441.3).abs() < 1e-6 && (mode(a, b, rate).1 - 1.7).abs() < 1e-9);
        let tone = |f: f64, t60: f64| {
            move |i: usize| (TAU * f * i as f64 / rate).sin() * (-3.0 * LN_10 * i as f64 / (rate * t60)).exp()
        };
        let (one, two) = (tone(441.3, 1.7), tone(900.0, 0.9));
        let x: Vec<f64> = (0..48_000).map(|i| one(i) + 0.3 * two(i)).collect();
        assert!(cents(partial(&x, rate, 440.0, 30.0).0, 441.3).abs() < 0.01);
        assert!((t60(&x, rate, 441.3) - 1.7).abs() < 0.01, "{}", t60(&x, rate, 441.3));
        assert!((t60(&x, rate, 900.0) - 0.9).abs() < 0.01);
        assert!((period(&x[..4800], rate, 0.002, 0.0025).0 * 441.3 - 1.0).abs() < 0.02);
        let mut seed = 1_u64;
        let noise: Vec<f64> = (0..48_000)
            .map(|_| {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
            })
            .collect();
        assert!(flatness(&noise, rate, 500.0, 5000.0) > 0.85 && flatness(&x, rate, 300.0, 1500.0) < 0.1);
    }
}
