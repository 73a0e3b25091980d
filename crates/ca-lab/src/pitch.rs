//! The strongest partial of a sound.

use ca_report::{Sound, Spectrum};

/// Powers of the bins of a column.
pub fn spectrum(column: &[f64], rate: f64) -> Option<Spectrum> {
    // as a sound it would be cut off at full scale
    let top = column.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut sound = Sound::new(rate, &["probe".into()]);
    for v in column {
        sound.push(&[if top > 0.0 { v / top } else { 0.0 }]);
    }
    let mut found = Spectrum::of(&sound)?;
    found.power.iter_mut().flatten().for_each(|p| *p *= top * top);
    Some(found)
}

/// Frequency of the strongest partial \[Hz\], by a parabola through the levels about the strongest bin that stands above
/// its neighbours: what rises towards an end of the range is none.
pub fn partial(s: &Spectrum) -> Option<f64> {
    let p = s.power.first()?;
    let lowest = (ca_report::LOWEST / s.step).ceil().max(1.0) as usize;
    let peak = |at: &usize| p[*at] > 0.0 && p[*at - 1] <= p[*at] && p[*at + 1] <= p[*at];
    let at = (lowest..p.len().checked_sub(1)?).filter(peak).max_by(|a, b| p[*a].total_cmp(&p[*b]))?;
    let [l, m, r] = [at - 1, at, at + 1].map(|i| p[i].max(f64::MIN_POSITIVE).ln());
    let bend = l - 2.0 * m + r;
    let shift = if bend < 0.0 { 0.5 * (l - r) / bend } else { 0.0 };
    Some((at as f64 + shift) * s.step)
}
