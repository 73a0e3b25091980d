//! Reference for a model: damped sinusoids with as many free numbers, fitted to the same time.
//!
//! The strongest are found one after the other and refined together by least squares over the samples. Each has a
//! frequency, a decay, and an amplitude and phase for each channel; several channels thus favour the sinusoids.

use super::normal_equations::{Normal, dot};
use super::target::Samples;
use ca_report::Hann;

/// Initial decays: times to fall by 60 dB \[s\].
const STARTS: [f64; 4] = [0.1, 0.4, 1.5, 6.0];
/// Longest window in which the next sinusoid is searched \[s\].
const WINDOW: f64 = 0.4;
/// Maximum number of least-squares steps.
const STEPS: usize = 25;

/// Frequency and decay, per sample.
#[derive(Clone, Copy)]
struct Shape {
    turn: f64,
    fall: f64,
}

impl Shape {
    /// Returns `n` samples of its cosine and sine.
    fn parts(self, n: usize) -> [Vec<f64>; 2] {
        let (mut cos, mut sin) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for i in 0..n {
            let (s, c) = libm::sincos(self.turn * i as f64);
            let e = libm::exp(-self.fall * i as f64);
            cos.push(e * c);
            sin.push(e * s);
        }
        [cos, sin]
    }
}

/// Returns the amplitudes of cosines and sines by least squares, and the residual.
fn amplitudes(parts: &[[Vec<f64>; 2]], sound: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let columns: Vec<Vec<f64>> = parts.iter().flatten().map(|c| c[..sound.len()].to_vec()).collect();
    let gradient: Vec<f64> = columns.iter().map(|c| -dot(c, sound)).collect();
    let found = Normal::of(&columns).map_or_else(|| vec![0.0; columns.len()], |n| n.step(&gradient, 0.0));
    let mut left = sound.to_vec();
    for (c, a) in columns.iter().zip(&found) {
        left.iter_mut().zip(c).for_each(|(l, c)| *l -= a * c);
    }
    (found, left)
}

fn energy(left: &Samples) -> f64 {
    left.iter().map(|c| dot(c, c)).sum()
}

fn lefts(shapes: &[Shape], sound: &Samples) -> Samples {
    let n = sound.first().map_or(0, Vec::len);
    let parts: Vec<[Vec<f64>; 2]> = shapes.iter().map(|s| s.parts(n)).collect();
    sound.iter().map(|c| amplitudes(&parts, c).1).collect()
}

/// Angular frequency of the strongest part of the residual, per sample.
fn strongest(left: &Samples, rate: f64) -> f64 {
    let n = left.first().map_or(0, Vec::len).min((WINDOW * rate) as usize).max(64);
    let mut windows = Hann::new(n, 4 * n.next_power_of_two());
    let mut whole = vec![0.0; windows.size() / 2 + 1];
    for c in left {
        windows.add(c, 0, &mut whole);
    }
    let lowest = (25.0 / rate * windows.size() as f64) as usize;
    let at = (lowest..whole.len()).max_by(|a, b| whole[*a].total_cmp(&whole[*b])).unwrap_or(lowest);
    std::f64::consts::TAU * at as f64 / windows.size() as f64
}

/// Refines all shapes together by least-squares steps.
fn refined(mut shapes: Vec<Shape>, sound: &Samples) -> Vec<Shape> {
    let n = sound.first().map_or(0, Vec::len);
    let mut best = energy(&lefts(&shapes, sound));
    let mut damping: f64 = 1e-3;
    for _ in 0..STEPS {
        let parts: Vec<[Vec<f64>; 2]> = shapes.iter().map(|s| s.parts(n)).collect();
        let mut columns: Vec<Vec<f64>> = vec![Vec::new(); 2 * shapes.len()];
        let mut r: Vec<f64> = Vec::new();
        for c in sound {
            let (found, left) = amplitudes(&parts, c);
            r.extend(left);
            for (k, [cos, sin]) in parts.iter().enumerate() {
                let [a, b] = [found[2 * k], found[2 * k + 1]];
                let at = |i: usize| i as f64;
                columns[2 * k].extend((0..n).map(|i| at(i) * (a * sin[i] - b * cos[i])));
                columns[2 * k + 1].extend((0..n).map(|i| at(i) * (a * cos[i] + b * sin[i])));
            }
        }
        // amplitudes are free, so only the part of each derivative that they cannot produce counts
        let width = r.len() / sound.len().max(1);
        for c in &mut columns {
            let whole: Vec<f64> = c.chunks(width.max(1)).flat_map(|x| amplitudes(&parts, x).1).collect();
            *c = whole;
        }
        let gradient: Vec<f64> = columns.iter().map(|c| dot(c, &r)).collect();
        let Some(normal) = Normal::of(&columns) else { break };
        let mut better = false;
        for _ in 0..4 {
            let step = normal.step(&gradient, damping);
            let tried: Vec<Shape> = shapes
                .iter()
                .enumerate()
                .map(|(k, s)| Shape {
                    turn: (s.turn + step[2 * k]).clamp(1e-6, std::f64::consts::PI),
                    fall: (s.fall + step[2 * k + 1]).clamp(0.0, 1.0),
                })
                .collect();
            let left = energy(&lefts(&tried, sound));
            if left < best {
                better = best - left > 1e-6 * best;
                (best, shapes) = (left, tried);
                damping *= 0.1;
                break;
            }
            damping = (damping * 10.0).max(1e-6);
        }
        if !better {
            break;
        }
    }
    shapes
}

/// Fits damped sinusoids from `onset` to `fitted` and continues them to `there`, the end of the sound.
pub(super) fn continued(
    samples: &Samples,
    (onset, fitted, there): (usize, usize, usize),
    count: usize,
    rate: f64,
) -> Samples {
    let sound: Samples = samples.iter().map(|c| c[onset..fitted].to_vec()).collect();
    let mut shapes: Vec<Shape> = Vec::new();
    for _ in 0..count {
        let turn = strongest(&lefts(&shapes, &sound), rate);
        let tried = STARTS.map(|t60| {
            let mut more = shapes.clone();
            more.push(Shape { turn, fall: libm::log(1000.0) / (t60 * rate) });
            more
        });
        let left = |s: &Vec<Shape>| energy(&lefts(s, &sound));
        let Some(best) = tried.into_iter().min_by(|a, b| left(a).total_cmp(&left(b))) else { break };
        shapes = refined(best, &sound);
    }
    let n = fitted - onset;
    let parts: Vec<[Vec<f64>; 2]> = shapes.iter().map(|s| s.parts(there - onset)).collect();
    sound
        .iter()
        .map(|c| {
            let found = amplitudes(&parts, &c[..n]).0;
            let mut all = vec![0.0; there];
            for (k, part) in parts.iter().flatten().enumerate() {
                all[onset..].iter_mut().zip(part).for_each(|(x, p)| *x += found[k] * p);
            }
            all
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_damped_sinusoids_are_found_and_go_on() {
        let rate = 8000.0;
        let at = |i: usize| {
            let t = i as f64 / rate;
            (-3.0 * t).exp() * (1382.3 * t + 0.4).sin() + 0.3 * (-9.0 * t).exp() * (2501.0 * t).cos()
        };
        let sound: Samples = vec![(0..8000).map(at).collect()];
        let all = continued(&sound, (0, 3000, 8000), 2, rate);
        let off = (0..8000).map(|i| (all[0][i] - sound[0][i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-3, "{off}");
    }
}
