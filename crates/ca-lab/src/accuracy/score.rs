//! How far a run is from the reference: as a motion, as a spectrum, in pitch and in decay.

use super::play::Columns;
use crate::pitch::{spectrum, strongest};
use ca_report::Spectrum;

/// What is said of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// ‖x − reference‖ / ‖reference‖ of the worst probe
    pub error: f64,
    /// the same of the levels of the spectrum
    pub spectrum: f64,
    /// how much the strongest partial is too high \[cents\]; none of silence
    pub cents: Option<f64>,
    /// how much more the second half is than it should be, against the first \[dB\]
    pub decay: f64,
}

fn square(v: impl Iterator<Item = f64>) -> f64 {
    v.map(|v| v * v).sum()
}

/// ‖a − b‖ / ‖b‖ of the worst column; of columns that are nothing in `b`, whether they are in `a`.
pub fn apart(a: &Columns, b: &Columns) -> f64 {
    let one = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let (miss, whole) = (square(a.iter().zip(b).map(|(a, b)| a - b)), square(b.iter().copied()));
        if whole > 0.0 { (miss / whole).sqrt() } else { miss.sqrt() }
    };
    a.iter().zip(b).map(one).fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v) })
}

/// Compares a run with what it should be.
pub fn score(run: &Columns, truth: &Columns, rate: f64) -> Score {
    let halves = |c: &[f64]| {
        let (first, last) = c.split_at(c.len() / 2);
        10.0 * (square(last.iter().copied()) / square(first.iter().copied())).log10()
    };
    let (mut far, mut cents, mut decay): (f64, Option<f64>, f64) = (0.0, None, 0.0);
    for (a, b) in run.iter().zip(truth) {
        if let (Some(x), Some(y)) = (spectrum(a, rate), spectrum(b, rate)) {
            let level = |s: &Spectrum| s.power[0].iter().map(|p| p.sqrt()).collect::<Vec<f64>>();
            let d = apart(&vec![level(&x)], &vec![level(&y)]);
            far = far.max(d);
            if let (Some(f), Some(g), None) = (strongest(&x), strongest(&y), cents) {
                cents = Some(1200.0 * (f / g).log2());
            }
        }
        let d = halves(a) - halves(b);
        if d.is_finite() && d.abs() > decay.abs() {
            decay = d;
        }
    }
    Score { error: apart(run, truth), spectrum: far, cents, decay }
}
