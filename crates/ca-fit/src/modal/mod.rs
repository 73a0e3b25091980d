//! Matches the modes of the model to the partials of the recording, without a render.
//!
//! Each partial has a weight by its distance to the nearest mode, so that partials without a mode nearby, missing or
//! foreign, have no effect. The width of that weight starts wide and narrows. Frequencies come first: for each number
//! that moves them, a scan over some semitones of the linearised modes finds the start, so that a start a semitone off
//! is not a trap. Decays follow by the same steps.

pub(super) mod partials;

use super::normal_equations::{Normal, dot};
use super::player::{AudibleMode, Player};
use ca_lab::Failure;
use partials::Partial;

/// Step of a search coordinate for derivatives.
const STEP: f64 = 1e-3;
/// Range of the scan, as a logarithm of frequency: two and a half semitones either way.
const SCAN: f64 = 2.5 / 12.0 * std::f64::consts::LN_2;
/// A cent, as a logarithm.
const CENT: f64 = std::f64::consts::LN_2 / 1200.0;
/// Width of the weights in cents, for each round.
const NEAR: [f64; 5] = [40.0, 20.0, 10.0, 5.0, 3.0];
/// Uncertainty of a decay from peaks, as a logarithm.
const DECAY: f64 = 0.2;
/// Modes below this level are ignored.
const FAINT: f64 = 1e-3;

/// Search coordinates at which the modes lie at the partials.
pub(super) struct Placed {
    pub places: Vec<f64>,
    /// Coordinates that move modes at all.
    pub moved: Vec<bool>,
}

/// Modes and their derivatives by the search coordinates.
struct Linear {
    modes: Vec<AudibleMode>,
    /// Derivatives of the logarithms of frequency and of decay: by coordinate, by mode.
    f: Vec<Vec<f64>>,
    t60: Vec<Vec<f64>>,
}

impl Linear {
    fn at(player: &Player, places: &[f64], ends: &[[f64; 2]]) -> Result<Option<Linear>, Failure> {
        let Some(modes) = player.modes(places)? else { return Ok(None) };
        let (mut f, mut t60) = (Vec::new(), Vec::new());
        for k in 0..places.len() {
            let mut moved = places.to_vec();
            let step = if places[k] + STEP > ends[k][1] { -STEP } else { STEP };
            moved[k] += step;
            let Some(other) = player.modes(&moved)?.filter(|o| o.len() == modes.len()) else { return Ok(None) };
            let over = |of: &dyn Fn(&AudibleMode) -> f64| -> Vec<f64> {
                let slope = |(a, b): (&AudibleMode, &AudibleMode)| {
                    let s = libm::log(of(b) / of(a)) / step;
                    if s.is_finite() && s.abs() > 1e-7 { s } else { 0.0 }
                };
                modes.iter().zip(&other).map(slope).collect()
            };
            f.push(over(&|m| m.f));
            t60.push(over(&|m| m.t60));
        }
        Ok(Some(Linear { modes, f, t60 }))
    }

    /// Returns the nearest mode of each partial and its distance as a logarithm, after a move by `by`.
    fn nearest(&self, partials: &[Partial], by: &[f64]) -> Vec<(usize, f64)> {
        let moved = |j: usize| libm::log(self.modes[j].f) + by.iter().zip(&self.f).map(|(b, f)| b * f[j]).sum::<f64>();
        let all: Vec<(usize, f64)> =
            (0..self.modes.len()).filter(|j| self.modes[*j].level > FAINT).map(|j| (j, moved(j))).collect();
        let one = |p: &Partial| {
            let f = libm::log(p.f);
            let off = all.iter().map(|(j, m)| (*j, f - m));
            off.min_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((0, f64::INFINITY))
        };
        partials.iter().map(one).collect()
    }

    fn misfit(&self, partials: &[Partial], by: &[f64], near: f64) -> f64 {
        let far = |off: f64| if off.is_finite() { off * off / (off * off + near * near) } else { 1.0 };
        self.nearest(partials, by).iter().zip(partials).map(|((_, off), p)| weight(p) * far(*off)).sum()
    }
}

/// Weight of a partial, by its level above the faintest.
fn weight(p: &Partial) -> f64 {
    (p.level + 66.0) / 66.0
}

/// Returns search coordinates at which modes lie at the partials; `None` where the model lacks usable modes, or the
/// varied numbers do not move them.
pub(super) fn place(
    player: &Player,
    partials: &[Partial],
    start: &[f64],
    ends: &[[f64; 2]],
) -> Result<Option<Placed>, Failure> {
    let mut places = start.to_vec();
    let clamp = |places: &mut [f64]| {
        places.iter_mut().zip(ends).for_each(|(p, e)| *p = p.clamp(e[0], e[1]));
    };
    if partials.is_empty() {
        return Ok(None);
    }
    let mut moved = vec![false; places.len()];
    for (round, near) in NEAR.iter().map(|c| c * CENT).enumerate() {
        let Some(linear) = Linear::at(player, &places, ends)? else { return Ok(None) };
        let moves: Vec<usize> =
            (0..places.len()).filter(|k| linear.f[*k].iter().chain(&linear.t60[*k]).any(|s| *s != 0.0)).collect();
        if moves.is_empty() {
            return Ok(None);
        }
        for k in &moves {
            moved[*k] = true;
        }
        let mut by = vec![0.0; places.len()];
        if round == 0 {
            scan(&linear, partials, &mut by);
        }
        for _ in 0..4 {
            let step = step(&linear, partials, &by, &moves, near);
            moves.iter().zip(step).for_each(|(k, s)| by[*k] += s.clamp(-1.5, 1.5));
        }
        places.iter_mut().zip(&by).for_each(|(p, b)| *p += b.clamp(-1.5, 1.5));
        clamp(&mut places);
    }
    Ok(Some(Placed { places, moved }))
}

/// Finds the best start along each coordinate that moves frequencies.
fn scan(linear: &Linear, partials: &[Partial], by: &mut [f64]) {
    let near = 15.0 * CENT;
    let still = vec![0.0; by.len()];
    let mut best = linear.misfit(partials, &still, near);
    for k in 0..by.len() {
        let most = linear.f[k].iter().fold(0.0_f64, |m, s| m.max(s.abs()));
        if most < 0.05 {
            continue;
        }
        for n in -100..=100 {
            let mut tried = still.clone();
            tried[k] = f64::from(n) / 100.0 * SCAN / most;
            let misfit = linear.misfit(partials, &tried, near);
            if misfit < best {
                best = misfit;
                by.copy_from_slice(&tried);
            }
        }
    }
}

/// Returns a step of the coordinates that move modes, by weighted least squares over matched partials.
fn step(linear: &Linear, partials: &[Partial], by: &[f64], moves: &[usize], near: f64) -> Vec<f64> {
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); moves.len()];
    let mut r: Vec<f64> = Vec::new();
    for ((j, off), p) in linear.nearest(partials, by).into_iter().zip(partials) {
        if !off.is_finite() {
            continue;
        }
        let counts = near * near / (off * off + near * near);
        let w = libm::sqrt(weight(p)) * counts;
        r.push(w * off / near);
        moves.iter().zip(&mut columns).for_each(|(k, c)| c.push(-w * linear.f[*k][j] / near));
        let model = libm::log(linear.modes[j].t60) + by.iter().zip(&linear.t60).map(|(b, t)| b * t[j]).sum::<f64>();
        if let Some(t60) = p.t60.filter(|_| model.is_finite() && p.level > -40.0) {
            let off = libm::log(t60) - model;
            let w = w * DECAY / libm::sqrt(off * off + DECAY * DECAY);
            r.push(w * off / DECAY);
            moves.iter().zip(&mut columns).for_each(|(k, c)| c.push(-w * linear.t60[*k][j] / DECAY));
        }
    }
    let gradient: Vec<f64> = columns.iter().map(|c| dot(c, &r)).collect();
    Normal::of(&columns).map_or_else(|| vec![0.0; moves.len()], |n| n.step(&gradient, 1e-4))
}
