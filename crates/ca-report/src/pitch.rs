//! Strongest partial of a sound, and decay of a level.

use crate::{LOWEST, Sound, Spectrum};

/// Returns the powers of the bins of a column, or `None` for an empty one.
pub fn spectrum(column: &[f64], rate: f64) -> Option<Spectrum> {
    // `Sound` would clip it at full scale
    let top = column.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut sound = Sound::new(rate, &["probe".into()]);
    for v in column {
        sound.push(&[if top > 0.0 { v / top } else { 0.0 }]);
    }
    let mut found = Spectrum::of(&sound)?;
    found.power.iter_mut().flatten().for_each(|p| *p *= top * top);
    Some(found)
}

/// Returns the frequency of the strongest partial \[Hz\], by a parabola through the levels around its bin. The bin
/// stands above both neighbours, which excludes a rise towards an end of the range.
pub fn partial(s: &Spectrum) -> Option<f64> {
    let p = s.power.first()?;
    let lowest = (LOWEST / s.step).ceil().max(1.0) as usize;
    let peak = |at: &usize| p[*at] > 0.0 && p[*at - 1] <= p[*at] && p[*at + 1] <= p[*at];
    let at = (lowest..p.len().checked_sub(1)?).filter(peak).max_by(|a, b| p[*a].total_cmp(&p[*b]))?;
    Some(apex(p, at) * s.step)
}

/// Returns a peak position in bins, by a parabola through the levels of `at` and both neighbours, which must exist.
pub fn apex(powers: &[f64], at: usize) -> f64 {
    let [l, m, r] = [at - 1, at, at + 1].map(|i| libm::log(powers[i].max(f64::MIN_POSITIVE)));
    let bend = l - 2.0 * m + r;
    at as f64 + if bend < 0.0 { 0.5 * (l - r) / bend } else { 0.0 }
}

/// Fits a line to levels \[dB\] from the loudest on, while they are less than `depth` below it. Returns its slope per
/// level and the number of levels, or `None` for fewer than two.
pub fn fall(levels: &[f64], depth: f64) -> Option<(f64, usize)> {
    let (loudest, top) = levels.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let tail = levels[loudest..].iter().take_while(|l| **l > top - depth);
    let points: Vec<(f64, f64)> = tail.enumerate().map(|(k, l)| (k as f64, *l)).collect();
    let n = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / n;
    let (mx, my) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - mx) * (p.1 - my)) / mean(&|p| (p.0 - mx).powi(2));
    (points.len() > 1).then_some((slope, points.len()))
}
