//! Derivatives, by one parameter, of all numbers that a scene begins with.
//!
//! They are differences of the eighth order, central where the parameter can move both ways. The step is one at which
//! differences of a lower order agree. Smooth functions are then exact to about 1e-12; a function with a corner or a
//! jump, such as a contact closed at load on one side only, agrees at no step and is refused.

use crate::{Error, Parameter};
use ca_core::internal::scene;
use ca_core::{Identity, Scene};
use std::ops::Range;

/// Steps relative to the value, in the order of trial: narrow ones; wide ones, for values so small that a relative
/// change is rounded away; very narrow ones, for curves in tables, whose pieces are short.
const STEPS: [f64; 13] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e-6, 1e-7];
/// Number of steps that are trusted without comparison. A wide step may skip a feature between its ends, and a very
/// narrow step may be lost in rounding.
const OWN: usize = 4;
/// Index of the first very narrow step, and the tolerance of such steps across the corners of a table.
const NARROWEST: usize = 11;
const CORNERS: f64 = 1e-3;
/// Relative error of the differences: requested, and required of the best step.
const ASKED: f64 = 1e-9;
const ENOUGH: f64 = 1e-7;
/// Relative rounding error of a number from the compiler.
const ROUNDING: f64 = 4e-16;
/// Changes below this (positions in m, coefficients and so on) count as zero if rounding explains them.
const NOTHING: f64 = 1e-17;

/// Weights of the values at 1, 2, … steps, less those at −1, −2, …: eighth order, sixth order.
const CENTRAL: [[f64; 4]; 2] =
    [[4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0], [3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0, 0.0]];
/// Weights of the values at 0, 1, 2, … steps: eighth order, seventh order.
const ONE_SIDED: [[f64; 9]; 2] = [
    [-761.0 / 280.0, 8.0, -14.0, 56.0 / 3.0, -35.0 / 2.0, 56.0 / 5.0, -14.0 / 3.0, 8.0 / 7.0, -1.0 / 8.0],
    [-363.0 / 140.0, 7.0, -21.0 / 2.0, 35.0 / 3.0, -35.0 / 4.0, 21.0 / 5.0, -7.0 / 6.0, 1.0 / 7.0, 0.0],
];

/// Structure and numbers of a scene at its start.
pub struct Start {
    /// As [`Scene::structure`].
    structure: Identity,
    numbers: Vec<f64>,
    /// Curves given to ports; these are not differentiated.
    gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// Ranges of numbers of one kind. The error of each number is judged by the largest in its range.
    alike: Vec<Range<usize>>,
}

impl Start {
    /// Returns the start of a scene, whose numbers are 0 afterwards.
    pub fn of(scene: &mut Scene) -> Start {
        let mut numbers = Vec::new();
        scene::numbers(scene, &mut |v| numbers.push(*v));
        // as in `scene::numbers`: vectors in space, elongations, rest positions, shares in modes, couplings of modes
        let l = &scene.layout;
        let lengths = [
            4 * l.links.reach.len(),
            l.links.e0.len(),
            l.places.rest.len(),
            l.places.shares.len(),
            l.places.couplings.len(),
        ];
        let mut first = 0;
        let alike = lengths.map(|n| {
            first += n;
            first - n..first
        });
        let gestures = std::mem::take(&mut scene.about.gestures);
        Start { alike: alike.to_vec(), structure: scene::structure(scene), numbers, gestures }
    }

    /// Returns whether all numbers change linearly, but for rounding, from two steps down to two steps up.
    fn are_lines(&self, steps: &[[Vec<f64>; 2]]) -> bool {
        let [[up, down], [up2, down2]] = steps else { return false };
        let line = |i: usize| {
            let (v, most) = (self.numbers[i], up2[i].abs().max(down2[i].abs()).max(self.numbers[i].abs()));
            let off = |a: f64, b: f64| ((a - v) - b).abs() <= 8.0 * ROUNDING * most;
            off(up[i], v - down[i]) && off(up2[i], 2.0 * (up[i] - v)) && off(down2[i], 2.0 * (down[i] - v))
        };
        (0..self.numbers.len()).all(line)
    }

    pub fn len(&self) -> usize {
        self.numbers.len()
    }
}

enum Obstacle {
    /// The model has an error there, such as a number out of range.
    Model(String),
    Built,
    Gesture,
    Rough,
}

/// Returns the derivatives of the numbers of `start`; `compiled` is the start at another value of `parameter`.
pub fn derivatives(
    start: &Start,
    parameter: &Parameter,
    compiled: &dyn Fn(f64) -> Result<Start, String>,
) -> Result<Vec<f64>, Error> {
    let (mut obstacle, size) = (Obstacle::Rough, size(parameter));
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut narrow: Option<(f64, Found)> = None;
    for (i, part) in STEPS.into_iter().enumerate() {
        // if a narrow step changes the structure, a wide one does too
        if i == OWN && !matches!(obstacle, Obstacle::Rough) {
            break;
        }
        let h = size * part;
        let at = |k: i32| -> Result<Vec<f64>, Obstacle> {
            let other = compiled(parameter.value + f64::from(k) * h).map_err(Obstacle::Model)?;
            if other.gestures != start.gestures {
                return Err(Obstacle::Gesture);
            }
            let same = other.structure == start.structure && other.numbers.len() == start.numbers.len();
            if same { Ok(other.numbers) } else { Err(Obstacle::Built) }
        };
        let found = match central(start, &at, h) {
            Err(Obstacle::Model(_)) => match one_sided(start, &at, h) {
                Err(Obstacle::Model(_)) => one_sided(start, &|k| at(-k), -h),
                found => found,
            },
            found => found,
        };
        match found {
            Ok(mut found) => {
                let (off, all) = found.derivatives(&start.alike);
                obstacle = Obstacle::Rough;
                let near = |off: f64| if i < NARROWEST { 10.0 * off } else { CORNERS };
                if i >= OWN && narrow.as_ref().is_some_and(|(off, n)| !n.may_be(&all, near(*off))) {
                    continue;
                }
                if i < OWN && narrow.as_ref().is_none_or(|n| off < n.0) {
                    narrow = Some((off, found));
                }
                if best.as_ref().is_none_or(|b| off < b.0) {
                    best = Some((off, all));
                }
            }
            Err(o) => obstacle = o,
        }
        if best.as_ref().is_some_and(|b| b.0 <= ASKED) {
            break;
        }
    }
    match best {
        Some((off, all)) if off <= ENOUGH => return Ok(all),
        Some(_) => obstacle = Obstacle::Rough,
        None => {}
    }
    let name = &parameter.name;
    Err(Error::refused(match obstacle {
        Obstacle::Model(what) => {
            format!("no derivative by `{name}`: the model has errors on both sides of its value: {what}")
        }
        Obstacle::Built => {
            format!(
                "no derivative by `{name}`: it changes the structure of the scene, not only its numbers; the compiler may leave \
                 out what is 0, so write a small value instead of 0"
            )
        }
        Obstacle::Gesture => {
            format!("no derivative by `{name}`: it changes a gesture of the model, and gestures are not differentiated")
        }
        Obstacle::Rough => format!(
            "no derivative by `{name}` at its value: the coefficients or the initial state of the scene have a corner or a jump \
             there, or change only by rounding"
        ),
    }))
}

/// Unit of the steps: the value, or 1e-3 for 0, rounded to a power of two.
fn size(parameter: &Parameter) -> f64 {
    let size = if parameter.value == 0.0 { 1e-3 } else { parameter.value.abs() };
    size.log2().round().exp2()
}

struct Found {
    h: f64,
    high: Vec<f64>,
    low: Vec<f64>,
    /// Largest magnitude of each number.
    most: Vec<f64>,
    /// Largest change of each number.
    change: Vec<f64>,
}

impl Found {
    fn new(start: &Start, h: f64) -> Found {
        let none = vec![0.0; start.numbers.len()];
        let most = start.numbers.iter().map(|v| v.abs()).collect();
        Found { h, high: none.clone(), low: none.clone(), most, change: none }
    }

    fn add(&mut self, values: &[f64], base: &[f64], weights: [f64; 2]) {
        for (i, (v, base)) in values.iter().zip(base).enumerate() {
            // the difference first, so that a number that does not change gives exactly 0
            let change = v - base;
            self.high[i] += weights[0] * change;
            self.low[i] += weights[1] * change;
            self.most[i] = self.most[i].max(v.abs());
            self.change[i] = self.change[i].max(change.abs());
        }
    }

    /// Returns whether other derivatives agree with these to `near`, and are nonzero where these are known to be.
    fn may_be(&self, other: &[f64], near: f64) -> bool {
        let largest = self.largest();
        let agree = |(i, by): (usize, &f64)| {
            let apart = (self.high[i] - by * self.h).abs();
            let lost = *by == 0.0 && self.high[i] != 0.0 && self.is_resolved(i);
            !lost && apart <= near * (self.change[i] + largest * self.most[i]) + NOTHING
        };
        other.iter().enumerate().all(agree)
    }

    /// Error bound of a difference.
    fn off(&self, i: usize) -> f64 {
        (self.high[i] - self.low[i]).abs() + ROUNDING * self.most[i]
    }

    /// Returns whether the change is well above its error bound.
    fn is_resolved(&self, i: usize) -> bool {
        self.off(i) <= 1e-4 * self.change[i]
    }

    /// Largest relative change of a resolved number.
    fn largest(&self) -> f64 {
        let resolved = (0..self.high.len()).filter(|i| self.change[*i] > 0.0 && self.is_resolved(*i));
        resolved.map(|i| self.change[i] / self.most[i]).fold(0.0, f64::max)
    }

    /// Returns the largest relative error, and the derivatives. Each error is divided by the change of its number plus
    /// the change at the largest resolved rate, so that numbers that only change by rounding do not matter.
    fn derivatives(&mut self, alike: &[Range<usize>]) -> (f64, Vec<f64>) {
        for range in alike {
            let most = &mut self.most[range.clone()];
            let all = most.iter().copied().fold(0.0, f64::max);
            most.fill(all);
        }
        let (all, largest) = (0..self.high.len(), self.largest());
        let changes = |i: &usize| self.change[*i] > 0.0;
        let counts = |i: &usize| self.is_resolved(*i) || self.change[*i] > NOTHING;
        let part_off = |i: usize| self.off(i) / (self.change[i] + largest * self.most[i]);
        let worst = all.clone().filter(changes).filter(counts).map(part_off);
        // a non-finite value is the largest error
        let worst = worst.fold(0.0, |most: f64, v| if v <= most { most } else { v });
        let none = |i: usize| !self.is_resolved(i) && self.change[i] <= NOTHING;
        let derivatives = all.map(|i| if none(i) { 0.0 } else { self.high[i] / self.h }).collect();
        (if worst.is_nan() { f64::INFINITY } else { worst }, derivatives)
    }
}

/// Differences by values on both sides; four values are enough where all numbers change linearly, as most do.
fn central(start: &Start, at: &dyn Fn(i32) -> Result<Vec<f64>, Obstacle>, h: f64) -> Result<Found, Obstacle> {
    let mut found = Found::new(start, h);
    let [high, low] = CENTRAL;
    let mut two: Vec<[Vec<f64>; 2]> = Vec::with_capacity(2);
    for ((steps, high), low) in (1..).zip(high).zip(low) {
        let weights = [high, low];
        let (up, down) = (at(steps)?, at(-steps)?);
        found.add(&up, &start.numbers, weights);
        found.add(&down, &start.numbers, weights.map(|w| -w));
        if steps <= 2 {
            two.push([up, down]);
        }
        if steps == 2 && start.are_lines(&two) {
            let [up, down] = &two[1];
            let slope = |(up, down): (&f64, &f64)| 0.25 * (up - down);
            found.high = up.iter().zip(down).map(slope).collect();
            found.low.clone_from(&found.high);
            break;
        }
    }
    Ok(found)
}

fn one_sided(start: &Start, at: &dyn Fn(i32) -> Result<Vec<f64>, Obstacle>, h: f64) -> Result<Found, Obstacle> {
    let mut found = Found::new(start, h);
    let [high, low] = ONE_SIDED;
    for ((steps, high), low) in (0..).zip(high).zip(low).skip(1) {
        found.add(&at(steps)?, &start.numbers, [high, low]);
    }
    Ok(found)
}
