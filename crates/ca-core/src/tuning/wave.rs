//! What a waveguide is made of: whole delays between its junctions, and at the far end a filter for what is left.
//!
//! ```text
//!   rigid ─┬─ D₁ ─┬─ junction ─┬─ D₂ ─┬─ junction ─┬─ N, loss, allpass ─┬─ rigid
//!          └──────┘            └──────┘            └────────────────────┘
//! ```
//! A velocity wave that leaves a junction comes back from the near end turned over, D₁ samples later and through a loss
//! of its own, a + b (z + 1/z) with a + 2b = 1; from the far end
//! H(z) = z^−(N+1) · (a + b (z + 1/z)) · (c + 1/z)/(1 + c/z) later, turned over too (docs/numerics.md §7.1). The loss
//! has linear phase and makes no energy where a, b ≥ 0 and a + 2b ≤ 1; the allpass makes up for the fraction of a
//! sample.
//!
//! Decides to solve for the pole itself, at the complex z of the pitch and the decay that were asked for, through all
//! junctions and their masses, instead of for a phase at a real frequency: pitch and decay of the fundamental are then
//! exact to rounding, whatever hangs in the string. The near end takes half of what high frequencies lose more than the
//! lowest, or they would be caught between it and a heavy junction, and nothing at 0 Hz: so it holds the string to its
//! place, where a loss would let it slip under a steady pull. All else is lost at the far end.

use super::problem::Problem;
use crate::numeric::Plain;
use alloc::format;
use alloc::vec::Vec;
use core::f64::consts::{LN_10, TAU};
use nalgebra::Complex;

/// Samples that a wave may take to go up and down a string.
const LONGEST: f64 = 1e6;
/// Steps of the solution; each gains several digits.
const STEPS: u32 = 40;

/// A string as it was asked for, in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveguideSpec {
    /// fundamental \[Hz\]
    pub f: f64,
    /// its time to decay by 60 dB \[s\]; infinite for none
    pub t60: f64,
    /// another frequency \[Hz\], and the time there \[s\]
    pub high: Option<[f64; 2]>,
    /// wave impedance \[kg/s\]
    pub z: f64,
    /// where the junctions are, from 0 to 1, rising
    pub at: Vec<f64>,
    /// mass of each junction \[kg\], if written
    pub m: Option<f64>,
}

impl WaveguideSpec {
    /// Mass of a junction \[kg\]: as written, or what its links `need`, and no less than a 16th of what the string has
    /// in a sample, so that what it rings with by itself, at half the sound rate, dies within a millisecond or so.
    pub fn mass(&self, need: f64, tick_dt: f64) -> f64 {
        self.m.unwrap_or(need.max(self.z * tick_dt / 16.0))
    }

    /// Mass of the CEL that a junction of mass `m` is, beside a damper of 2z \[kg\].
    pub fn cell(&self, m: f64, tick_dt: f64) -> f64 {
        m + self.z * tick_dt
    }
}

/// The filter at an end.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Loss<N = f64> {
    /// middle tap
    pub a: N,
    /// each of the taps beside it
    pub b: N,
    /// of the allpass, 0 for a delay of one sample
    pub c: N,
}

impl Loss {
    /// The same in the numbers of a tick, as `to` makes them.
    pub fn map<N>(self, to: impl Fn(f64) -> N) -> Loss<N> {
        Loss { a: to(self.a), b: to(self.b), c: to(self.c) }
    }

    /// Gain of the taps, but for their delay of one sample, where `wave` is (z + 1/z)/2.
    fn gain(&self, wave: Complex<f64>) -> Complex<f64> {
        wave * (2.0 * self.b) + self.a
    }
}

/// A string in samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// to the near end and back with its filter, from each junction to the next, to the far end and back without its
    /// filter \[samples\]
    pub delays: Vec<usize>,
    /// at the near end, where it loses anything
    pub near: Option<Loss>,
    /// at the far end
    pub loss: Loss,
    /// the decay time at the second frequency \[s\], where the one asked for is out of reach
    pub reached: Option<f64>,
}

fn problem<T>(param: &'static str, title: impl Into<alloc::string::String>, help: &str) -> Result<T, Problem> {
    Err(Problem { title: title.into(), param, help: help.into() })
}

/// Brings a string into tune, with junctions of these `masses` \[kg\], at a tick of `tick_dt` \[s\].
///
/// # Errors
/// Where no delay line has this pitch and decay, with the parameter to change.
pub fn tune(asked: &WaveguideSpec, masses: &[f64], tick_dt: f64) -> Result<Tuned, Problem> {
    let dies = || problem("t60", "it dies out before it has swung once", "use a longer `t60`");
    if asked.f * asked.t60 < 0.25 {
        return dies();
    }
    let delays = places(asked, tick_dt)?;
    let omega = TAU * asked.f * tick_dt;
    let z = {
        let radius = libm::exp(-3.0 * LN_10 * tick_dt / asked.t60);
        Complex::new(radius * libm::cos(omega), radius * libm::sin(omega))
    };
    // z to the power −n
    let later = |n: f64| {
        let size = libm::exp(3.0 * LN_10 * tick_dt / asked.t60 * n);
        Complex::new(size * libm::cos(omega * n), -size * libm::sin(omega * n))
    };
    // what the near end and all junctions give back to a wave from the far end
    let wave = (z + z.inv()) * 0.5;
    let near = near(asked, tick_dt).filter(|_| delays[0] >= 3);
    let mut back = -later(delays[0] as f64) * near.map_or(Complex::from(1.0), |l| l.gain(wave));
    for (i, m) in masses.iter().enumerate() {
        if i > 0 {
            back *= later(2.0 * delays[i] as f64);
        }
        // a mass of the scheme is 2m/T (z−1)/(z+1) to waves
        let mass = (z - 1.0) / (z + 1.0) * (2.0 * m / (tick_dt * asked.z)) * (back + 1.0);
        back = (back * 2.0 - mass) / (mass + 2.0);
    }
    let wanted = -back.inv();
    let heard = delays[0] as f64 + 2.0 * delays[1..].iter().sum::<usize>() as f64;
    let lag = -libm::atan2(wanted.im, wanted.re);
    let left = if lag < 0.0 { lag + TAU } else { lag } / omega;
    // beyond a whole turn the masses have made it another mode
    let wrapped = left > 1.0 / (asked.f * tick_dt) - heard + 0.5;
    if wrapped || left.is_nan() || left < 2.5 {
        return problem(
            if asked.m.is_some() { "m" } else { "at" },
            format!("{} Hz leaves no room for the far end", Plain(asked.f)),
            "use lighter junctions, place them further from the end, ask for a lower pitch, or raise `rate.sound`",
        );
    }
    let n = libm::floor(left - 1.5);
    let (mut part, mut g0) = (left - 1.0 - n, turn(asked, asked.t60));
    let (mut loss, mut reached) = (Loss { a: 1.0, b: 0.0, c: 0.0 }, None);
    for _ in 0..STEPS {
        (loss, reached) = far(asked, near.as_ref(), wave, g0, tick_dt);
        loss.c = libm::sin(0.5 * omega * (1.0 - part)) / libm::sin(0.5 * omega * (1.0 + part));
        let allpass = (z.inv() + loss.c) / (z.inv() * loss.c + 1.0);
        let off = wanted / (later(n + 1.0) * loss.gain(wave) * allpass);
        part -= libm::atan2(off.im, off.re) / omega;
        g0 *= libm::sqrt(off.norm_sqr());
    }
    let passive = loss.a >= 0.0 && loss.b >= 0.0 && loss.a + 2.0 * loss.b <= 1.0 + 1e-12;
    if !(passive && loss.c.abs() < 1.0) {
        return dies();
    }
    let delays = delays.into_iter().chain([n as usize]).collect();
    Ok(Tuned { delays, near, loss, reached })
}

/// Whole delays up to the last junction; the place of a junction is met to half a sample.
fn places(asked: &WaveguideSpec, tick_dt: f64) -> Result<Vec<usize>, Problem> {
    let whole = 1.0 / (asked.f * tick_dt);
    if whole > LONGEST {
        return problem(
            "f",
            format!("{} Hz is a string of more than {LONGEST:e} samples", Plain(asked.f)),
            "ask for a higher pitch",
        );
    }
    let mut delays = Vec::with_capacity(asked.at.len() + 1);
    let mut before = 0.0;
    for at in &asked.at {
        // the near end is reached and left in one delay; further on each way has its own
        let share = if delays.is_empty() { 1.0 } else { 0.5 };
        let delay = libm::round(share * (at * whole - before));
        if delay < 1.0 {
            return problem(
                "at",
                format!("the point at {at} is less than {:.4} behind what stands before it", 0.5 / (share * whole)),
                "let the points rise from the near end at 0 to the far end at 1, further apart, or raise `rate.sound`",
            );
        }
        before += delay / share;
        delays.push(delay as usize);
    }
    if whole - before < 2.5 {
        return problem(
            "at",
            format!("{} Hz leaves no room behind the last point", Plain(asked.f)),
            "place it further from the far end, ask for a lower pitch, or raise `rate.sound`",
        );
    }
    Ok(delays)
}

/// Gain of a round trip that decays by 60 dB in `t60`.
fn turn(asked: &WaveguideSpec, t60: f64) -> f64 {
    libm::exp(-3.0 * LN_10 / (t60 * asked.f))
}

/// The taps of the near end: half of the loss between the two frequencies, no more than half of that at the first.
fn near(asked: &WaveguideSpec, tick_dt: f64) -> Option<Loss> {
    let [f, t60] = asked.high?;
    let [low, high] = [asked.f, f].map(|f| 1.0 - libm::cos(TAU * f * tick_dt));
    let g0 = turn(asked, asked.t60);
    let half = 1.0 - libm::sqrt(turn(asked, t60) / g0);
    let double = (half / high).min(0.5 * (1.0 - g0) / low).min(0.5);
    (double > 0.0).then_some(Loss { a: 1.0 - double, b: 0.5 * double, c: 0.0 })
}

/// The taps of the far end with gain `g0` at the pole, and such a gain at the second frequency that its decay is as
/// asked for; or as near to that as no energy is made, with the decay time that is reached.
fn far(asked: &WaveguideSpec, near: Option<&Loss>, wave: Complex<f64>, g0: f64, tick_dt: f64) -> (Loss, Option<f64>) {
    let Some([f, t60]) = asked.high else { return (Loss { a: g0, b: 0.0, c: 0.0 }, None) };
    let (low, high) = (wave.re, libm::cos(TAU * f * tick_dt));
    let before = near.map_or(1.0, |l| l.gain(Complex::from(high)).re);
    let ideal = (g0 - turn(asked, t60) / before) / (low - high);
    // a ≥ 2b keeps the highest frequencies from turning over, a + 2b ≤ 1 the lowest from growing
    let most = (g0 / (1.0 + low)).min((1.0 - g0) / (1.0 - low));
    let double = ideal.min(most).max(0.0);
    let side = double * wave.im;
    let a = libm::sqrt((g0 * g0 - side * side).max(0.0)) - double * low;
    let there = (before * (a + double * high)).max(f64::MIN_POSITIVE);
    let reached = -3.0 / (asked.f * libm::log10(there));
    (Loss { a, b: 0.5 * double, c: 0.0 }, (ideal > most * (1.0 + 1e-9)).then_some(reached))
}
