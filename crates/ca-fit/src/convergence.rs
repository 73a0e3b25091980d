//! End of a search: whether it has settled, and the uncertainty of each number.
//!
//! A search has settled where the next step, by the derivatives there, changes each number by less than its deviation.
//! A small improvement in the last step does not show this: the step may be short because of damping or outdated
//! derivatives. The search goes on until it has settled or renders run out.
//!
//! Deviations are checked on nested windows of time. The same derivatives give, by one step, the numbers that fit a
//! shorter window. These may differ from the numbers found by √(d² − D²), and by D in any case, with the deviations d
//! of the short and D of the whole window (Hausman 1978). A greater difference shows that the model lacks something,
//! and D grows by the same factor.

use super::loss::{Loss, STRETCHES};
use super::normal_equations::{Normal, dot};
use super::player::Player;
use super::search::{EXACT, Point, Rules, Slopes, Stop, descend, free_columns};
use super::stages::Work;
use super::verdict::{Known, StopReason};
use ca_lab::Failure;

/// Deviation, as a logarithm or in units of the scale, above which a number is not determined.
const UNKNOWN: f64 = 0.7;
/// Steps between two checks, and the least improvement of a step.
const STEPS: usize = 8;
const GAINS: f64 = 1e-3;
/// Nested windows, as fractions of the whole one.
const NESTED: [f64; 3] = [0.5, 0.65, 0.8];

/// Makes the loss of the sound up to a sample.
pub(super) type LossUntil<'a> = &'a dyn Fn(usize) -> Box<dyn Loss>;

/// Deviations at a point, and whether the search has settled there.
struct Look {
    deviations: Vec<Option<f64>>,
    settled: bool,
}

/// Numbers that fit one window of time, estimated from a point.
struct Estimate {
    deviations: Vec<Option<f64>>,
    /// Step from the point along each search coordinate.
    step: Vec<f64>,
    left: f64,
}

impl Work<'_> {
    /// Searches on with the loss up to sample `until`, until it settles, a descent is stuck or renders run out.
    pub fn settled(
        &self,
        player: &mut Player,
        (within, until): (LossUntil, usize),
        mut point: Point,
        slopes: &mut Option<Slopes>,
    ) -> Result<(Point, Known), Failure> {
        let spare = self.spare();
        let loss = &*within(until);
        loop {
            let look = self.look(player, loss, &point, slopes)?;
            let ended = |halt: StopReason| Known { deviations: look.deviations.clone(), halt };
            if look.settled {
                let deviations = self.checked(within, until, &point, slopes.as_ref(), look.deviations);
                return Ok((point, Known { deviations, halt: StopReason::Settled }));
            }
            if player.left() <= spare {
                return Ok((point, ended(StopReason::Renders)));
            }
            // numbers that are not determined would move without end, and their long steps would shorten all others
            let still: Vec<bool> = look.deviations.iter().map(Option::is_none).collect();
            let rules = Rules { ends: &self.ends, still: &still, steps: STEPS, gains: GAINS, spare };
            let (next, stop) = descend(player, loss, point.clone(), slopes, &rules)?;
            if next.places == point.places {
                let halt = if stop == Stop::Renders { StopReason::Renders } else { StopReason::Stuck };
                return Ok((next, ended(halt)));
            }
            point = next;
        }
    }

    /// Returns the deviations of the search coordinates and whether the search has settled.
    fn look(
        &self,
        player: &mut Player,
        loss: &dyn Loss,
        point: &Point,
        slopes: &mut Option<Slopes>,
    ) -> Result<Look, Failure> {
        let n = self.varied.len();
        let unknown = Look { deviations: Known::nothing(n).deviations, settled: false };
        if !slopes.as_ref().is_some_and(|s| s.is_at(point)) {
            if player.left() < n as u32 {
                return Ok(unknown);
            }
            *slopes = Some(Slopes::at(player, point, &self.ends)?);
        }
        let found = slopes.as_ref().and_then(|s| self.estimate(loss, point, s));
        let Some(Estimate { deviations, step, left }) = found else { return Ok(unknown) };
        let within = |k: usize| deviations[k].is_none_or(|d| step[k].abs() <= d);
        Ok(Look { settled: left < EXACT || (0..n).all(within), deviations })
    }

    /// Estimates the numbers that fit one window; `None` if a derivative is not finite.
    fn estimate(&self, loss: &dyn Loss, point: &Point, slopes: &Slopes) -> Option<Estimate> {
        let n = self.varied.len();
        let point = &Point { free: loss.settle(&point.sound, point.free), ..point.clone() };
        let r = loss.residual(&point.sound, point.free);
        let mut columns = slopes.columns(loss, point, &r);
        columns.extend(free_columns(loss, point, &r));
        let normal = Normal::of(&columns)?;
        let mut sums = vec![vec![0.0; columns.len()]; STRETCHES];
        for (i, stretch) in loss.stretches().into_iter().enumerate() {
            sums[stretch].iter_mut().zip(&columns).for_each(|(s, c)| *s += c[i] * r[i]);
        }
        let degrees = r.len().saturating_sub(columns.len()).max(1);
        let left = dot(&r, &r);
        let variances = normal.variances(&sums, left / degrees as f64);
        let deviations: Vec<Option<f64>> =
            variances.into_iter().take(n).map(|v| v.map(libm::sqrt).filter(|d| *d < UNKNOWN)).collect();
        let still: Vec<bool> = deviations.iter().map(Option::is_none).collect();
        let step = self.step(point, &columns, &r, &still);
        Some(Estimate { deviations, step, left })
    }

    /// Returns the deviations of the whole window, widened if nested windows differ by more than expected.
    fn checked(
        &self,
        within: LossUntil,
        until: usize,
        point: &Point,
        slopes: Option<&Slopes>,
        deviations: Vec<Option<f64>>,
    ) -> Vec<Option<f64>> {
        let onset = self.target.onset;
        let of = |until: usize| slopes.and_then(|s| self.estimate(&*within(until), point, s));
        let Some(whole) = of(until) else { return deviations };
        let mut wider = vec![1.0_f64; deviations.len()];
        for part in NESTED {
            let Some(nested) = of(onset + (part * (until - onset) as f64) as usize) else { continue };
            for (k, wider) in wider.iter_mut().enumerate() {
                let (Some(d), Some(own)) = (whole.deviations[k], nested.deviations[k]) else { continue };
                let expected = libm::sqrt((own * own - d * d).max(d * d));
                let off = (nested.step[k] - whole.step[k]).abs();
                if expected > 0.0 {
                    *wider = wider.max(off / expected);
                }
            }
        }
        let widened = |(d, wider): (Option<f64>, f64)| d.map(|d| d * wider).filter(|d| *d < UNKNOWN);
        deviations.into_iter().zip(wider).map(widened).collect()
    }

    /// Returns the undamped step along each coordinate that is not `still`, within the bounds.
    fn step(&self, point: &Point, columns: &[Vec<f64>], residual: &[f64], still: &[bool]) -> Vec<f64> {
        let n = self.varied.len();
        let gradient: Vec<f64> = columns.iter().map(|c| dot(c, residual)).collect();
        // a coordinate at a bound stays there if the step would cross it
        let held = |k: usize| {
            let [from, to] = self.ends[k];
            still[k] || (point.places[k] <= from && gradient[k] > 0.0) || (point.places[k] >= to && gradient[k] < 0.0)
        };
        let moves: Vec<usize> = (0..columns.len()).filter(|k| *k >= n || !held(*k)).collect();
        let of: Vec<Vec<f64>> = moves.iter().map(|k| columns[*k].clone()).collect();
        let against: Vec<f64> = moves.iter().map(|k| gradient[*k]).collect();
        let Some(normal) = Normal::of(&of) else { return vec![f64::INFINITY; n] };
        let mut step = vec![0.0; n];
        for (k, by) in moves.into_iter().zip(normal.step(&against, 0.0)).filter(|(k, _)| *k < n) {
            let at = point.places[k];
            step[k] = (at + by).clamp(self.ends[k][0], self.ends[k][1]) - at;
        }
        step
    }
}
