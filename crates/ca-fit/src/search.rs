//! Levenberg–Marquardt descent for a distance of sounds, with as few renders as possible.
//!
//! The sound itself is differentiated, with one render for each varied number. This serves every distance, gain, delay
//! and window length until the search moves on. Between two such rounds, steps correct the derivatives of the residuals
//! (Broyden) without renders; they are computed again when a step that relies on them fails.

use super::loss::{Free, Loss};
use super::normal_equations::{Normal, dot};
use super::player::Player;
use super::target::Samples;
use ca_lab::Failure;

/// Step of a search coordinate for derivatives, so small that the phase of a high partial hardly changes.
const STEP: f64 = 1e-6;
/// Relative step of gain, and step of delay \[samples\], for derivatives.
const GAIN: f64 = 1e-6;
const DELAY: f64 = 1e-3;
/// Longest step of a search coordinate.
const FAR: f64 = 0.7;
/// Longest step of the delay \[samples\].
const LATE: f64 = 8.0;
/// Step lengths that are tried with the same derivatives.
const TRIES: usize = 4;

/// Point of the search, with the sound rendered there.
#[derive(Clone)]
pub(super) struct Point {
    pub places: Vec<f64>,
    pub free: Free,
    pub sound: Samples,
}

/// Derivatives of the sound by the search coordinates, and the point they belong to.
pub(super) struct Slopes {
    at: Vec<f64>,
    of: Vec<Samples>,
}

impl Slopes {
    pub fn at(player: &mut Player, point: &Point, ends: &[[f64; 2]]) -> Result<Slopes, Failure> {
        let mut of = Vec::new();
        for (k, end) in ends.iter().enumerate() {
            let mut places = point.places.clone();
            let step = if places[k] + STEP > end[1] { -STEP } else { STEP };
            places[k] += step;
            // if the model fails there, the derivative is unknown and taken as 0
            let heard = player.render(&places)?.unwrap_or_else(|| point.sound.clone());
            let slope = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (b - a) / step).collect();
            of.push(point.sound.iter().zip(&heard).map(slope).collect());
        }
        Ok(Slopes { at: point.places.clone(), of })
    }

    pub fn is_at(&self, point: &Point) -> bool {
        self.at == point.places
    }

    pub fn columns(&self, loss: &dyn Loss, point: &Point, residual: &[f64]) -> Vec<Vec<f64>> {
        let one = |slope: &Samples| {
            let near = |(h, s): (&Vec<f64>, &Vec<f64>)| h.iter().zip(s).map(|(h, s)| h + STEP * s).collect();
            let heard: Samples = point.sound.iter().zip(slope).map(near).collect();
            difference(&loss.residual(&heard, point.free), residual, STEP)
        };
        self.of.iter().map(one).collect()
    }
}

fn difference(there: &[f64], here: &[f64], step: f64) -> Vec<f64> {
    there.iter().zip(here).map(|(a, b)| (a - b) / step).collect()
}

/// Returns the derivatives of the residuals by gain and delay, where these are unknowns.
pub(super) fn free_columns(loss: &dyn Loss, point: &Point, residual: &[f64]) -> Vec<Vec<f64>> {
    let [gain, delay] = loss.free();
    let mut all = Vec::new();
    if gain {
        let step = GAIN * point.free.gain;
        let free = Free { gain: point.free.gain + step, ..point.free };
        all.push(difference(&loss.residual(&point.sound, free), residual, GAIN));
    }
    if delay {
        let free = Free { delay: point.free.delay + DELAY, ..point.free };
        all.push(difference(&loss.residual(&point.sound, free), residual, DELAY));
    }
    all
}

pub(super) struct Rules<'a> {
    pub ends: &'a [[f64; 2]],
    /// Coordinates that stay fixed; any beyond the end of the slice may move.
    pub still: &'a [bool],
    pub steps: usize,
    /// Least improvement of a step, as a fraction of the sum of squares.
    pub gains: f64,
    /// Renders reserved for later.
    pub spare: u32,
}

/// Reason for the end of a descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// The last step improved little, or almost no residual is left.
    Small,
    /// The maximum number of steps was reached, and each improved.
    Steps,
    /// With new derivatives, steps of all lengths failed to improve.
    Stuck,
    /// Too few renders were left for another step.
    Renders,
}

/// A smaller sum of squares is only rounding.
pub(super) const EXACT: f64 = 1e-18;

fn sum(r: &[f64]) -> f64 {
    dot(r, r)
}

/// Descends from a point and returns the end with the reason. `slopes` holds derivatives, used if they belong to the
/// start; at the end it holds the last ones computed.
pub(super) fn descend(
    player: &mut Player,
    loss: &dyn Loss,
    mut point: Point,
    slopes: &mut Option<Slopes>,
    rules: &Rules,
) -> Result<(Point, Stop), Failure> {
    let n = point.places.len();
    point.free = loss.settle(&point.sound, point.free);
    let mut residual = loss.residual(&point.sound, point.free);
    let mut own: Option<Vec<Vec<f64>>> = None;
    let mut fresh = false;
    let mut damping: f64 = 1e-3;
    let mut step = 0;
    let mut stop = Stop::Steps;
    while step < rules.steps {
        let columns = match &mut own {
            Some(columns) => columns,
            none => {
                if !slopes.as_ref().is_some_and(|s| s.is_at(&point)) {
                    if player.left() < rules.spare + n as u32 + 1 {
                        stop = Stop::Renders;
                        break;
                    }
                    *slopes = Some(Slopes::at(player, &point, rules.ends)?);
                }
                fresh = true;
                let Some(slopes) = slopes.as_ref() else { break };
                none.insert(slopes.columns(loss, &point, &residual))
            }
        };
        let beside = free_columns(loss, &point, &residual);
        let cost = sum(&residual);
        // a coordinate at a bound stays there if the step would cross it
        let held: Vec<bool> = (0..n)
            .map(|k| {
                let slope = dot(&columns[k], &residual);
                let [from, to] = rules.ends[k];
                let still = rules.still.get(k).copied().unwrap_or(false);
                still || (point.places[k] <= from && slope > 0.0) || (point.places[k] >= to && slope < 0.0)
            })
            .collect();
        let moves: Vec<usize> = (0..n).filter(|k| !held[*k]).collect();
        let all: Vec<Vec<f64>> = moves.iter().map(|k| columns[*k].clone()).chain(beside.iter().cloned()).collect();
        let gradient: Vec<f64> = all.iter().map(|c| dot(c, &residual)).collect();
        let Some(normal) = Normal::of(&all) else {
            stop = Stop::Stuck;
            break;
        };
        let mut next: Option<(Point, Vec<f64>)> = None;
        let mut by = vec![0.0; n];
        for _ in 0..TRIES {
            if player.left() <= rules.spare {
                stop = Stop::Renders;
                break;
            }
            let step = normal.step(&gradient, damping);
            by = vec![0.0; n];
            let longest = moves.iter().zip(&step).fold(0.0_f64, |m, (_, s)| m.max(s.abs()));
            let part = if longest > FAR { FAR / longest } else { 1.0 };
            let mut places = point.places.clone();
            for (k, s) in moves.iter().zip(&step) {
                places[*k] = (places[*k] + part * s).clamp(rules.ends[*k][0], rules.ends[*k][1]);
                by[*k] = places[*k] - point.places[*k];
            }
            let mut free = point.free;
            if loss.free()[1] {
                free.delay += (part * step[step.len() - 1]).clamp(-LATE, LATE);
            }
            if let Some(heard) = player.render(&places)? {
                free = loss.settle(&heard, free);
                let r = loss.residual(&heard, free);
                if sum(&r) < cost {
                    damping = (damping * 0.1).max(1e-9);
                    next = Some((Point { places, free, sound: heard }, r));
                    break;
                }
            }
            if by.iter().all(|b| b.abs() < 1e-12) {
                break;
            }
            damping = (damping * 10.0).max(1e-4);
            // the corrected derivatives may be the reason
            if !fresh {
                break;
            }
        }
        let Some((found, r)) = next else {
            if stop == Stop::Renders {
                break;
            }
            if fresh {
                stop = Stop::Stuck;
                break;
            }
            own = None;
            continue;
        };
        let gained = 1.0 - sum(&r) / cost;
        let long: f64 = dot(&by, &by);
        if long > 0.0 {
            // Broyden: the unexpected part of the change, without the effect of gain and delay
            let [gain, delay] = loss.free();
            let mut expected: Vec<f64> = r.iter().zip(&residual).map(|(a, b)| a - b).collect();
            let mut off: Vec<f64> = Vec::new();
            if gain {
                off.push(found.free.gain / point.free.gain - 1.0);
            }
            if delay {
                off.push(found.free.delay - point.free.delay);
            }
            let known = columns.iter().zip(&by).chain(beside.iter().zip(&off));
            for (c, b) in known {
                expected.iter_mut().zip(c).for_each(|(e, c)| *e -= b * c);
            }
            for (c, b) in columns.iter_mut().zip(&by) {
                c.iter_mut().zip(&expected).for_each(|(c, e)| *c += e * b / long);
            }
        }
        fresh = false;
        (point, residual) = (found, r);
        step += 1;
        if gained < rules.gains || sum(&residual) < EXACT {
            stop = Stop::Small;
            break;
        }
        // little improvement with corrected derivatives: they are outdated
        if gained < 0.5 {
            own = None;
        }
    }
    Ok((point, stop))
}
