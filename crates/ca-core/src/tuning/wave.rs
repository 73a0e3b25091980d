//! Tunes a waveguide: whole delays between its junctions, and a filter at the far end for the fraction of a sample.
//!
//! ```text
//!   rigid ─┬─ D₁ ─┬─ junction ─┬─ D₂ ─┬─ junction ─┬─ N, loss, allpass ─┬─ rigid
//!          └──────┘            └──────┘            └────────────────────┘
//! ```
//! A velocity wave from a junction towards the near end comes back inverted, D₁ samples later and through a loss filter
//! a + b (z + 1/z) with a + 2b = 1. Towards the far end it comes back inverted through H(z) = z^−(N+1) · (a + b (z +
//! 1/z)) · (c + 1/z)/(1 + c/z) (docs/numerics.md §7.1). The loss has linear phase and makes no energy for a, b ≥ 0 and
//! a + 2b ≤ 1. The allpass supplies the fraction of a sample.
//!
//! Tuning solves for the pole itself, at the complex z of the requested pitch and decay, through all junctions and
//! their masses. Pitch and decay of the fundamental are then exact to rounding, whatever the junctions weigh. A
//! solution for the phase at a real frequency would not be.
//!
//! The near end takes half of the additional loss at high frequencies, which else would be trapped between it and a
//! heavy junction. It loses nothing at 0 Hz, so the string does not slip under a steady force. The far end takes all
//! other losses.

use super::problem::Problem;
use crate::numeric::Plain;
use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::{LN_10, TAU};
use nalgebra::Complex;

/// Longest round trip of a wave on a string, in samples.
const LONGEST: f64 = 1e6;
/// Iterations of the solution; each gains several digits.
const STEPS: u32 = 40;

/// Requested properties of a string, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveguideSpec {
    /// fundamental \[Hz\]
    pub f: f64,
    /// decay time of the fundamental by 60 dB \[s\]; infinite for none
    pub t60: f64,
    /// another frequency \[Hz\] and the decay time there \[s\]
    pub high: Option<[f64; 2]>,
    /// wave impedance \[kg/s\]
    pub z: f64,
    /// positions of the junctions, from 0 to 1, rising
    pub at: Vec<f64>,
    /// mass of each junction \[kg\], if specified
    pub m: Option<f64>,
}

impl WaveguideSpec {
    /// Returns the mass of a junction \[kg\]: the specified one, or what its links `need`.
    ///
    /// The minimum is a 16th of the mass that the string has per sample. The junction's own oscillation, at half the
    /// sound rate, then decays within about a millisecond.
    pub fn mass(&self, need: f64, tick_dt: f64) -> f64 {
        self.m.unwrap_or(need.max(self.z * tick_dt / 16.0))
    }

    /// Returns the mass of the CEL that represents a junction of mass `m`, beside a damper of 2z \[kg\].
    pub fn cell(&self, m: f64, tick_dt: f64) -> f64 {
        m + self.z * tick_dt
    }
}

/// Filter at an end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Loss<N = f64> {
    /// middle tap
    pub a: N,
    /// each of the two outer taps
    pub b: N,
    /// coefficient of the allpass, 0 for a delay of one sample
    pub c: N,
}

impl Loss {
    /// Converts the coefficients with `to`, usually to the number type of a tick.
    pub fn map<N>(self, to: impl Fn(f64) -> N) -> Loss<N> {
        Loss { a: to(self.a), b: to(self.b), c: to(self.c) }
    }

    /// Returns the gain of the taps without their delay of one sample; `wave` is (z + 1/z)/2.
    fn gain(&self, wave: Complex<f64>) -> Complex<f64> {
        wave * (2.0 * self.b) + self.a
    }
}

/// A tuned string, in samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// delays \[samples\]: near end and back with its filter, between junctions, far end and back without its filter
    pub delays: Vec<usize>,
    /// filter of the near end, if it has losses
    pub near: Option<Loss>,
    /// filter of the far end
    pub loss: Loss,
    /// decay time at the second frequency \[s\], if the requested one cannot be reached
    pub reached: Option<f64>,
}

fn problem<T>(param: &'static str, title: impl Into<alloc::string::String>, help: &str) -> Result<T, Problem> {
    Err(Problem { title: title.into(), param, help: help.into() })
}

/// Meaning of the second decay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HighDecay {
    /// of a partial at that frequency on the string without the masses of its junctions
    Pole,
    /// gain of a round trip at that frequency, as up to arithmetic 7
    Gain,
}

/// A frequency with a decay: z = exp(−s T).
struct Pole {
    /// angle of a tick \[rad\]
    omega: f64,
    /// decay of a tick, as an exponent
    decay: f64,
    z: Complex<f64>,
    /// (z + 1/z)/2
    wave: Complex<f64>,
}

impl Pole {
    fn of(f: f64, t60: f64, tick_dt: f64) -> Pole {
        let (omega, decay) = (TAU * f * tick_dt, 3.0 * LN_10 * tick_dt / t60);
        let radius = libm::exp(-decay);
        let z = Complex::new(radius * libm::cos(omega), radius * libm::sin(omega));
        Pole { omega, decay, z, wave: (z + z.inv()) * 0.5 }
    }

    /// Returns z to the power −n.
    fn later(&self, n: f64) -> Complex<f64> {
        let size = libm::exp(self.decay * n);
        Complex::new(size * libm::cos(self.omega * n), -size * libm::sin(self.omega * n))
    }

    /// Returns what the far end must reflect, for this to be a pole: the negative inverse of the reflectance of the near
    /// end and all junctions.
    fn wanted(
        &self,
        asked: &WaveguideSpec,
        masses: &[f64],
        delays: &[usize],
        near: Option<&Loss>,
        tick_dt: f64,
    ) -> Complex<f64> {
        let mut back = -self.later(delays[0] as f64) * near.map_or(Complex::from(1.0), |l| l.gain(self.wave));
        for (i, m) in masses.iter().enumerate() {
            if i > 0 {
                back *= self.later(2.0 * delays[i] as f64);
            }
            // to waves, a mass of the scheme is the impedance 2m/T (z−1)/(z+1)
            let mass = (self.z - 1.0) / (self.z + 1.0) * (2.0 * m / (tick_dt * asked.z)) * (back + 1.0);
            back = (back * 2.0 - mass) / (mass + 2.0);
        }
        -back.inv()
    }

    /// Returns what the far end reflects, after `n` whole samples.
    fn reflected(&self, loss: &Loss, n: f64) -> Complex<f64> {
        let allpass = (self.z.inv() + loss.c) / (self.z.inv() * loss.c + 1.0);
        self.later(n + 1.0) * loss.gain(self.wave) * allpass
    }
}

/// Tunes a string with junctions of these `masses` \[kg\], at a tick of `tick_dt` \[s\].
///
/// # Errors
/// If no delay line has this pitch and decay, with the parameter to change.
pub fn tune(asked: &WaveguideSpec, masses: &[f64], tick_dt: f64, of: HighDecay) -> Result<Tuned, Problem> {
    let dies = || problem("t60", "it decays before it has oscillated once", "use a longer `t60`");
    if asked.f * asked.t60 < 0.25 {
        return dies();
    }
    let delays = places(asked, tick_dt)?;
    let near = near(asked, tick_dt).filter(|_| delays[0] >= 3);
    let first = Pole::of(asked.f, asked.t60, tick_dt);
    let omega = first.omega;
    let wanted = first.wanted(asked, masses, &delays, near.as_ref(), tick_dt);
    let second = asked.high.filter(|_| of == HighDecay::Pole).map(|[f, t60]| {
        let pole = Pole::of(f, t60, tick_dt);
        let light = alloc::vec![0.0; masses.len()];
        let wanted = pole.wanted(asked, &light, &delays, near.as_ref(), tick_dt);
        (pole, wanted)
    });
    let heard = delays[0] as f64 + 2.0 * delays[1..].iter().sum::<usize>() as f64;
    let lag = -libm::atan2(wanted.im, wanted.re);
    let left = if lag < 0.0 { lag + TAU } else { lag } / omega;
    // beyond a full turn the masses have made it another mode
    let wrapped = left > 1.0 / (asked.f * tick_dt) - heard + 0.5;
    if wrapped || left.is_nan() || left < 2.5 {
        return problem(
            if asked.m.is_some() { "m" } else { "at" },
            format!("{} Hz leaves no samples for the far end", Plain(asked.f)),
            "use lighter junctions, place them further from the end, use a lower pitch, or raise `rate.sound`",
        );
    }
    let n = libm::floor(left - 1.5);
    let (mut part, mut g0) = (left - 1.0 - n, loss_phase(asked, asked.t60));
    let mut g1 = high_gain(asked, near.as_ref(), tick_dt);
    let (mut loss, mut reached) = (Loss { a: 1.0, b: 0.0, c: 0.0 }, None);
    for _ in 0..STEPS {
        (loss, reached) = far(asked, near.as_ref(), first.wave, [g0, g1], tick_dt);
        loss.c = libm::sin(0.5 * omega * (1.0 - part)) / libm::sin(0.5 * omega * (1.0 + part));
        let off = wanted / first.reflected(&loss, n);
        part -= libm::atan2(off.im, off.re) / omega;
        g0 *= libm::sqrt(off.norm_sqr());
        if let (Some((pole, wanted)), None) = (&second, reached) {
            g1 *= libm::sqrt((wanted / pole.reflected(&loss, n)).norm_sqr());
        }
    }
    let passive = loss.a >= 0.0 && loss.b >= 0.0 && loss.a + 2.0 * loss.b <= 1.0 + 1e-12;
    if !(passive && loss.c.abs() < 1.0) {
        return dies();
    }
    let delays = delays.into_iter().chain([n as usize]).collect();
    Ok(Tuned { delays, near, loss, reached })
}

/// Returns the whole delays up to the last junction. The position of a junction is accurate to half a sample.
fn places(asked: &WaveguideSpec, tick_dt: f64) -> Result<Vec<usize>, Problem> {
    let whole = 1.0 / (asked.f * tick_dt);
    if whole > LONGEST {
        return problem(
            "f",
            format!("{} Hz needs a string of more than {LONGEST:e} samples", Plain(asked.f)),
            "use a higher pitch",
        );
    }
    let mut delays = Vec::with_capacity(asked.at.len() + 1);
    let mut before = 0.0;
    for at in &asked.at {
        // the near end is reached and left in one delay; further on each direction has its own
        let share = if delays.is_empty() { 1.0 } else { 0.5 };
        let delay = libm::round(share * (at * whole - before));
        if delay < 1.0 {
            return problem(
                "at",
                format!(
                    "the point at {at} is less than {:.4} behind the point or end before it",
                    0.5 / (share * whole)
                ),
                "order the points from the near end at 0 to the far end at 1, further apart, or raise `rate.sound`",
            );
        }
        before += delay / share;
        delays.push(delay as usize);
    }
    if whole - before < 2.5 {
        return problem(
            "at",
            format!("{} Hz leaves no samples behind the last point", Plain(asked.f)),
            "place it further from the far end, use a lower pitch, or raise `rate.sound`",
        );
    }
    Ok(delays)
}

/// Returns the gain of a round trip that decays by 60 dB in `t60`.
fn loss_phase(asked: &WaveguideSpec, t60: f64) -> f64 {
    libm::exp(-3.0 * LN_10 / (t60 * asked.f))
}

/// Returns the near taps: half of the loss between the two frequencies, at most half of the loss at the first.
fn near(asked: &WaveguideSpec, tick_dt: f64) -> Option<Loss> {
    let [f, t60] = asked.high?;
    let [low, high] = [asked.f, f].map(|f| 1.0 - libm::cos(TAU * f * tick_dt));
    let g0 = loss_phase(asked, asked.t60);
    let half = 1.0 - libm::sqrt(loss_phase(asked, t60) / g0);
    let double = (half / high).min(0.5 * (1.0 - g0) / low).min(0.5);
    (double > 0.0).then_some(Loss { a: 1.0 - double, b: 0.5 * double, c: 0.0 })
}

/// Returns the gain of the far taps at the second frequency for the requested decay of a round trip.
fn high_gain(asked: &WaveguideSpec, near: Option<&Loss>, tick_dt: f64) -> f64 {
    let Some([f, t60]) = asked.high else { return 0.0 };
    let high = Complex::from(libm::cos(TAU * f * tick_dt));
    loss_phase(asked, t60) / near.map_or(1.0, |l| l.gain(high).re)
}

/// Returns the far taps with gain `g0` at the pole and `g1` at the second frequency. If that would make energy, it takes
/// the nearest gain that does not, and returns the decay time reached.
fn far(
    asked: &WaveguideSpec,
    near: Option<&Loss>,
    wave: Complex<f64>,
    [g0, g1]: [f64; 2],
    tick_dt: f64,
) -> (Loss, Option<f64>) {
    let Some([f, _]) = asked.high else { return (Loss { a: g0, b: 0.0, c: 0.0 }, None) };
    let (low, high) = (wave.re, libm::cos(TAU * f * tick_dt));
    let before = near.map_or(1.0, |l| l.gain(Complex::from(high)).re);
    let ideal = (g0 - g1) / (low - high);
    // a ≥ 2b avoids inverting the highest frequencies, a + 2b ≤ 1 avoids growth of the lowest
    let most = (g0 / (1.0 + low)).min((1.0 - g0) / (1.0 - low));
    let double = ideal.min(most).max(0.0);
    let side = double * wave.im;
    let a = libm::sqrt((g0 * g0 - side * side).max(0.0)) - double * low;
    let there = (before * (a + double * high)).max(f64::MIN_POSITIVE);
    let reached = -3.0 / (asked.f * libm::log10(there));
    (Loss { a, b: 0.5 * double, c: 0.0 }, (ideal > most * (1.0 + 1e-9)).then_some(reached))
}
