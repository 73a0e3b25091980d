//! Figures of an instrument for its row.
//!
//! The decay is fitted to levels of short blocks. An integral from the end would be distorted by a sound that has not
//! died away. Early is the first 12 dB; late is the second half of the decay above the end, at most 60 dB.

use super::{BUILT, Cut, Plays, Render};
use crate::acoustics::{db, peak, slope};
use ca_io::level_and_fade::{FADE, QUIET};

/// Figures of a row that do not depend on the speed of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// Claimed pitch \[Hz\] and its error \[cents\].
    pub pitch: Option<[f64; 2]>,
    /// Spectral centroid of a soft and of a loud stroke \[Hz\].
    pub centroid: [f64; 2],
    /// T60, early and late \[s\].
    pub decay: [Option<f64>; 2],
    /// Largest sample \[dBFS\].
    pub level: f64,
    /// Largest mean of a channel \[dBFS\].
    pub dc: f64,
    /// Largest sample of the last 20 ms \[dBFS\].
    pub end: f64,
    /// True if `ca render` fades the end.
    pub faded: bool,
    /// Number of MAT and of LIA.
    pub modules: [usize; 2],
    /// Figure of each claim.
    pub claims: Vec<f64>,
}

/// Length of a block, whose level is one point of the decay \[s\].
const BLOCK: f64 = 0.02;
/// Range in which the decay is followed \[dB\].
const DEPTH: f64 = 60.0;
/// Range of the early decay \[dB\].
const EARLY: f64 = 12.0;
/// Longest T60 that counts as a decay \[s\].
const LONGEST: f64 = 60.0;

/// Returns T60 early and late \[s\] of a part of a render, from its loudest block on; `None` without a decay.
fn decay(r: &Render, from: f64, to: f64) -> [Option<f64>; 2] {
    let len = (BLOCK * r.rate) as usize;
    let parts: Vec<&[f64]> = r.sound.iter().map(|c| r.part(c, from, to)).collect();
    let blocks = parts[0].len() / len;
    let power = |b: usize| -> f64 {
        let one = |c: &&[f64]| {
            let x = &c[b * len..(b + 1) * len];
            let mean = x.iter().sum::<f64>() / len as f64;
            x.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()
        };
        parts.iter().map(one).sum::<f64>() / len as f64
    };
    let levels: Vec<f64> = (0..blocks).map(|b| 0.5 * db(power(b))).collect();
    let Some((loudest, top)) = levels.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return [None; 2];
    };
    let end = levels[loudest..].iter().take_while(|l| **l > top - DEPTH).count();
    let points: Vec<[f64; 2]> =
        levels[loudest..loudest + end].iter().enumerate().map(|(k, l)| [k as f64 * BLOCK, *l]).collect();
    let fit = |p: &[[f64; 2]]| {
        let t60 = -DEPTH / slope(p);
        (p.len() >= 3 && t60 > 0.0 && t60 < LONGEST).then_some(t60)
    };
    let early = points.iter().take_while(|p| p[1] > top - EARLY).count().max(3).min(points.len());
    [fit(&points[..early]), fit(&points[points.len() / 2..])]
}

/// Measures an instrument.
pub fn figures(p: &Plays) -> Figures {
    let i = p.instrument;
    let built = p.play(BUILT);
    let of_cut = |c: Cut| p.centroid(c);
    let level = |from: f64| built.sound.iter().map(|c| peak(&c[(from * built.rate) as usize..])).fold(0.0, f64::max);
    let n = built.sound[0].len() as f64;
    let end = level(n / built.rate - FADE);
    Figures {
        pitch: i.pitch.map(|pitch| [pitch.hertz, p.cents(pitch.hertz, pitch.cut)]),
        centroid: [of_cut(i.soft), of_cut(i.loud)],
        decay: decay(&p.play(i.decay.take), i.decay.from, i.decay.to),
        level: db(level(0.0)),
        dc: db(built.sound.iter().map(|c| (c.iter().sum::<f64>() / n).abs()).fold(0.0, f64::max)),
        end: db(end),
        faded: end > QUIET,
        modules: built.modules,
        claims: i.claims.iter().map(|c| (c.measure)(p)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{LN_10, TAU};

    /// Two exponentials: 60 dB in 0.5 s, and a twentieth as strong, 60 dB in 4 s.
    #[test]
    fn both_slopes_of_a_decay_are_found() {
        let at = |k: usize, t60: f64| (-3.0 * LN_10 * k as f64 / (t60 * 48e3)).exp();
        let x = |f: &dyn Fn(usize) -> f64| {
            (0..96_000).map(|k| f(k) * (TAU * 441.0 * k as f64 / 48e3).sin()).collect::<Vec<f64>>()
        };
        let render = |x| Render { rate: 48e3, sound: vec![x], probe: Vec::new(), modules: [0; 2], wall: 0.0 };
        let [early, late] = decay(&render(x(&|k| at(k, 0.5) + 0.05 * at(k, 4.0))), 0.0, 9.0).map(Option::unwrap);
        assert!((0.5..0.6).contains(&early) && (late - 4.0).abs() < 0.1, "{early} {late}");
        let [early, late] = decay(&render(x(&|k| at(k, 1.3))), 0.0, 9.0).map(Option::unwrap);
        assert!((early - 1.3).abs() < 0.02 && (late - 1.3).abs() < 0.02, "{early} {late}");
        assert_eq!(decay(&render(x(&|_| 0.5)), 0.0, 9.0)[1], None);
    }
}
