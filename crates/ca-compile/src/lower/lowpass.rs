//! Coefficients of the low-pass of the outputs.
//!
//! The filter is a windowed sinc (Kaiser): it has linear phase, so that all frequencies have the same delay, and its
//! length has a closed form. The author gives the edge of the pass band. The stop band begins at half the sound rate,
//! which gives the widest transition band and so the shortest filter and delay. Its attenuation is 80 dB, and the
//! ripple below the edge is as small.
//!
//! With several ticks per sample this filter prevents aliasing. It then runs at the tick rate with 100 dB, is always
//! present, and delays by whole samples. A cascade of half-band stages would save half of the products, but would be a
//! second kind of filter, which does not depend on `filter`.

use alloc::format;
use alloc::vec::Vec;
use ca_core::Unit;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;
use ca_model::quantity::show;
use core::f64::consts::PI;

/// Design attenuation of the window \[dB\]: 80, plus 6 for the ripple of the mirror image of the sinc, which it meets
/// at half the sound rate, plus 2 because Kaiser's formulas are fits.
const ATTENUATION: f64 = 88.0;
/// Design attenuation before ticks are dropped \[dB\]: 100, plus 4 for Kaiser's fits; no mirror image is near.
const ALIASES: f64 = 104.0;
/// Default edge as a fraction of the sound rate: 20 kHz of 48 kHz.
pub const WIDEST: f64 = 5.0 / 12.0;
/// Narrowest band between edge and half the sound rate, as a fraction of the latter; gives about 1600 coefficients.
const NARROWEST: f64 = 0.01;

/// Returns the first half of the coefficients, up to the middle one, for the pass band `edge` and the sound rate `rate`
/// \[Hz\] with `times` ticks per sample.
pub fn design(edge: f64, rate: f64, times: u32, span: Option<Span>, diags: &mut Diags) -> Vec<f64> {
    let (half, most) = (0.5 * rate, 0.5 * rate * (1.0 - NARROWEST));
    if edge > most {
        let title = format!(
            "`filter` of `[rate]`: {} Hz is not far enough below half the sound rate, {} Hz",
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

/// Modified Bessel function of order 0, by its power series, all of whose terms are positive.
fn bessel(x: f64) -> f64 {
    let (mut term, mut sum, mut k) = (1.0, 1.0, 1.0);
    while term > sum * f64::EPSILON {
        term *= 0.25 * x * x / (k * k);
        sum += term;
        k += 1.0;
    }
    sum
}
