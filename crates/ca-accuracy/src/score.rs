//! Distance of a run from the reference: as a motion, as a spectrum, in pitch and in decay.

use super::play::Columns;
use ca_report::Spectrum;
use ca_report::pitch::{partial, spectrum};

/// Scores of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    /// ‖x − reference‖ / ‖reference‖ of the worst probe.
    pub error: f64,
    /// The same for the levels of the spectrum.
    pub spectrum: f64,
    /// Pitch of the strongest partial above the reference \[cents\]; `None` for silence.
    pub cents: Option<f64>,
    /// Excess of the second half over the first, relative to the reference \[dB\].
    pub decay: f64,
}

fn square(v: impl Iterator<Item = f64>) -> f64 {
    v.map(|v| v * v).sum()
}

/// Returns ‖a − b‖ / ‖b‖ of the worst probe, or ‖a‖ for a probe that is 0 in `b`. Columns with the same number in `of`
/// are the axes of one probe, which is compared as a vector.
pub fn apart(a: &Columns, b: &Columns, of: &[usize]) -> f64 {
    let one = |probe: std::ops::Range<usize>| {
        let pairs = || a[probe.clone()].iter().zip(&b[probe.clone()]);
        let miss: f64 = pairs().map(|(a, b)| square(a.iter().zip(b).map(|(a, b)| a - b))).sum();
        let whole: f64 = pairs().map(|(_, b)| square(b.iter().copied())).sum();
        if whole > 0.0 { (miss / whole).sqrt() } else { miss.sqrt() }
    };
    let worst = probes(of).map(one);
    worst.fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v) })
}

fn probes(of: &[usize]) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    let mut at = 0;
    of.chunk_by(|a, b| a == b).map(move |c| {
        at += c.len();
        at - c.len()..at
    })
}

/// Compares a run with the reference.
pub fn score(run: &Columns, reference: &Columns, of: &[usize], rate: f64) -> Score {
    let energy = |columns: &[Vec<f64>], half: usize| -> f64 {
        let part = |c: &Vec<f64>| {
            let (first, last) = c.split_at(c.len() / 2);
            square([first, last][half].iter().copied())
        };
        columns.iter().map(part).sum()
    };
    let halves = |c: &[Vec<f64>]| 10.0 * (energy(c, 1) / energy(c, 0)).log10();
    let level = |s: &Spectrum| s.power[0].iter().map(|p| p.sqrt()).collect::<Vec<f64>>();
    let (mut far, mut cents, mut decay): (f64, Option<f64>, f64) = (0.0, None, 0.0);
    for probe in probes(of) {
        let (a, b) = (&run[probe.clone()], &reference[probe]);
        let of = |c: &[Vec<f64>]| c.iter().map(|c| spectrum(c, rate)).collect::<Option<Vec<Spectrum>>>();
        if let (Some(x), Some(y)) = (of(a), of(b)) {
            let levels = |all: &[Spectrum]| all.iter().map(level).collect::<Columns>();
            far = far.max(apart(&levels(&x), &levels(&y), &vec![0; x.len()]));
            // the axis of largest motion in the reference
            let most =
                (0..b.len()).max_by(|i, j| square(b[*i].iter().copied()).total_cmp(&square(b[*j].iter().copied())));
            let pitches = most.and_then(|k| partial(&x[k]).zip(partial(&y[k])));
            if let (Some((f, g)), None) = (pitches, cents) {
                cents = Some(1200.0 * (f / g).log2());
            }
        }
        let d = halves(a) - halves(b);
        if d.is_finite() && d.abs() > decay.abs() {
            decay = d;
        }
    }
    Score { error: apart(run, reference, of), spectrum: far, cents, decay }
}
