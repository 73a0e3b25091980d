//! Levenberg and Marquardt's steps for a distance of sounds, by as few renders as there can be.
//!
//! Decides that derivatives are those of the sound: one render for each number that is varied gives them for every distance, gain
//! and delay, and for windows of any length, until the search moves on. Between two such rounds the derivatives of the residuals
//! are corrected by what a step showed of them (Broyden), which costs nothing; they are made anew where a step that relies on
//! them fails.

use super::loss::{Free, Loss};
use super::normal::{Normal, dot};
use super::player::Player;
use super::target::Samples;
use ca_lab::Failure;

/// A difference of a place, for derivatives: small beside what turns the phase of a high partial.
const STEP: f64 = 1e-6;
/// Differences of gain, as a part of it, and of delay \[samples\].
const GAIN: f64 = 1e-6;
const DELAY: f64 = 1e-3;
/// Farthest step of a place.
const FAR: f64 = 0.7;
/// Farthest step of the delay \[samples\].
const LATE: f64 = 8.0;
/// Steps that are tried in one direction.
const TRIES: usize = 4;

/// A place of the search, with what is heard there.
#[derive(Clone)]
pub(super) struct Point {
    pub places: Vec<f64>,
    pub free: Free,
    pub heard: Samples,
}

/// The derivatives of what is heard, at some places.
pub(super) struct Slopes {
    at: Vec<f64>,
    of: Vec<Samples>,
}

impl Slopes {
    /// By a render for each place.
    pub fn at(player: &mut Player, point: &Point, ends: &[[f64; 2]]) -> Result<Slopes, Failure> {
        let mut of = Vec::new();
        for (k, end) in ends.iter().enumerate() {
            let mut places = point.places.clone();
            let step = if places[k] + STEP > end[1] { -STEP } else { STEP };
            places[k] += step;
            // a place beside one where the model sounds where it does not: nothing is known of this direction
            let heard = player.render(&places)?.unwrap_or_else(|| point.heard.clone());
            let slope = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (b - a) / step).collect();
            of.push(point.heard.iter().zip(&heard).map(slope).collect());
        }
        Ok(Slopes { at: point.places.clone(), of })
    }

    pub fn is_at(&self, point: &Point) -> bool {
        self.at == point.places
    }

    /// Derivatives of residuals.
    pub fn columns(&self, loss: &dyn Loss, point: &Point, residual: &[f64]) -> Vec<Vec<f64>> {
        let one = |slope: &Samples| {
            let near = |(h, s): (&Vec<f64>, &Vec<f64>)| h.iter().zip(s).map(|(h, s)| h + STEP * s).collect();
            let heard: Samples = point.heard.iter().zip(slope).map(near).collect();
            difference(&loss.residual(&heard, point.free), residual, STEP)
        };
        self.of.iter().map(one).collect()
    }
}

fn difference(there: &[f64], here: &[f64], step: f64) -> Vec<f64> {
    there.iter().zip(here).map(|(a, b)| (a - b) / step).collect()
}

/// Derivatives of residuals after gain and delay, where these are unknowns.
pub(super) fn free_columns(loss: &dyn Loss, point: &Point, residual: &[f64]) -> Vec<Vec<f64>> {
    let [gain, delay] = loss.free();
    let mut all = Vec::new();
    if gain {
        let step = GAIN * point.free.gain;
        let free = Free { gain: point.free.gain + step, ..point.free };
        all.push(difference(&loss.residual(&point.heard, free), residual, GAIN));
    }
    if delay {
        let free = Free { delay: point.free.delay + DELAY, ..point.free };
        all.push(difference(&loss.residual(&point.heard, free), residual, DELAY));
    }
    all
}

/// How a search is done and when it ends.
pub(super) struct Rules<'a> {
    pub ends: &'a [[f64; 2]],
    /// places that stay where they are; all that are not in it may move
    pub still: &'a [bool],
    /// most steps
    pub steps: usize,
    /// what a step has to gain, as a part of the sum of squares
    pub gains: f64,
    /// renders that are left for what comes after
    pub spare: u32,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// the last step gained little, or next to nothing is left
    Small,
    /// as many steps as there may be were made, and each gained
    Steps,
    /// no step of any length gained, by derivatives that were made anew
    Stuck,
    /// no renders were left for another step
    Renders,
}

/// A sum of squares with less than this is that of rounding.
pub(super) const EXACT: f64 = 1e-18;

fn sum(r: &[f64]) -> f64 {
    dot(r, r)
}

/// Goes down from a point, and says why it went no further. The slopes are those of the point, if they are known; those of where
/// it ends, if they are, are left there.
pub(super) fn descend(
    player: &mut Player,
    loss: &dyn Loss,
    mut point: Point,
    slopes: &mut Option<Slopes>,
    rules: &Rules,
) -> Result<(Point, Stop), Failure> {
    let n = point.places.len();
    point.free = loss.settle(&point.heard, point.free);
    let mut residual = loss.residual(&point.heard, point.free);
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
        // what is at an end and would go beyond stays there
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
                    next = Some((Point { places, free, heard }, r));
                    break;
                }
            }
            if by.iter().all(|b| b.abs() < 1e-12) {
                break;
            }
            damping = (damping * 10.0).max(1e-4);
            // derivatives that were corrected rather than made may be why
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
            // what the step showed beyond what was expected of it, without what gain and delay did to it
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
        // a step that gained little by corrected derivatives says that they are worn
        if gained < 0.5 {
            own = None;
        }
    }
    Ok((point, stop))
}
