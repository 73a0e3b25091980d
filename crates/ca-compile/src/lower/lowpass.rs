//! The low-pass of the outputs: its coefficients.
//!
//! Decides on a windowed sinc (Kaiser): linear phase, so that every frequency is late by the same number of ticks, and
//! a length in closed form. The author gives the edge of the pass band; the stop band begins at half the sound rate,
//! the band between them is as wide as it can be, so the filter is as short and as early as it can be. 80 dB are
//! promised there, and as little ripple below the edge.
//!
//! Where a sample has several ticks, it is this filter that keeps the ticks from folding into the sound: it goes at the
//! rate of the ticks, promises 100 dB, stands there unasked, and is late by whole samples. Half-band stages one after
//! the other would save half of the products, and be a second kind of filter that knows nothing of `filter`.

use alloc::format;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::quantity::show;
use core::f64::consts::PI;

/// What the window is made for \[dB\]: 80, and 6 because the sinc meets its mirror image at half the sound rate, whose
/// ripple adds, and 2 because Kaiser's formulas are fits.
const ATTENUATION: f64 = 88.0;
/// The same before ticks are left out \[dB\]: 100, and 4 because of Kaiser's fits; no mirror image is near.
const ALIASES: f64 = 104.0;
/// The edge where nothing is said, as a part of the sound rate: 20 kHz of 48 kHz.
pub const WIDEST: f64 = 5.0 / 12.0;
/// Narrowest band between edge and half the sound rate, as a part of the latter: some 1600 coefficients.
const NARROWEST: f64 = 0.01;

/// The first half of the coefficients up to the middle one, for the pass band `edge` and sound rate `rate` \[Hz\] with
/// `times` ticks in a sample.
pub fn design(edge: f64, rate: f64, times: u32, span: Option<Span>, diags: &mut Diags) -> Vec<f64> {
    let (half, most) = (0.5 * rate, 0.5 * rate * (1.0 - NARROWEST));
    if edge > most {
        let title = format!(
            "`filter` of `[rate]`: no room between {} Hz and half the sound rate, {} Hz",
            Plain(edge),
            Plain(half)
        );
        let d = Diag::error("E023", title).at(span.unwrap_or(Span::NONE), "too high");
        diags.push(d.help(format!("stay below {}, or raise `sound`", show(most, Unit::HERTZ))));
        return Vec::new();
    }
    let (ticks, down) = (rate * f64::from(times), if times > 1 { ALIASES } else { ATTENUATION });
    let band = 2.0 * PI * (half - edge) / ticks;
    let sides = libm::ceil((down - 7.95) / (2.285 * band) / 2.0) as usize + 1;
    let sides = sides.next_multiple_of(times as usize);
    let beta = 0.1102 * (down - 8.7);
    let cut = PI * (edge + half) / ticks;
    let tap = |i: usize| {
        let n = (sides - i) as f64;
        let window = bessel(beta * libm::sqrt(1.0 - (n / sides as f64) * (n / sides as f64))) / bessel(beta);
        window * if i == sides { cut / PI } else { libm::sin(cut * n) / (PI * n) }
    };
    let taps: Vec<f64> = (0..=sides).map(tap).collect();
    let steady = 2.0 * taps[..sides].iter().sum::<f64>() + taps[sides];
    taps.into_iter().map(|h| h / steady).collect()
}

/// Modified Bessel function of order 0, by its series, which only adds.
fn bessel(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > sum * f64::EPSILON {
        term *= 0.25 * x * x / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}
