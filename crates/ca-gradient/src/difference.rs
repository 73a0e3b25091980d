//! Difference: the derivatives of all numbers that a scene begins with, by one parameter.
//!
//! Decides for differences of the eighth order, central ones where the parameter may be moved both ways, with a step at which
//! those of a lower order agree: what is smooth is then exact to 1e-12 or so, and what is not (a corner, a jump, a contact that
//! is closed at load on one side only) agrees at no step and is refused.

use crate::{Error, Parameter};
use ca_core::internal::scene;
use ca_core::{Identity, Scene};
use std::ops::Range;

/// Steps, in parts of the value: narrower ones where what is built changes or bends, wider ones where a value is so small that
/// a change by parts of it is rounded away, and at last very narrow ones, for curves in tables, whose pieces are short.
const STEPS: [f64; 13] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e-6, 1e-7];
/// As many as are trusted by themselves: what is far away on both sides may be smooth without what is between, and a very narrow
/// step may be nothing to a number.
const OWN: usize = 4;
/// From which on they are the very narrow ones, and how far their derivatives may be from those across the corners of a table.
const NARROWEST: usize = 11;
const CORNERS: f64 = 1e-3;
/// How far differences may be off, relative: what is asked for, and what the best of all steps has to reach.
const ASKED: f64 = 1e-9;
const ENOUGH: f64 = 1e-7;
/// The rounding of a number by the compiler, in parts of itself.
const ROUNDING: f64 = 4e-16;
/// A change of places \[m\], coefficients and the like by less is none, if it is nothing but rounding.
const NOTHING: f64 = 1e-17;

/// Weights of the values at 1, 2, … steps, less those at −1, −2, …: of the eighth order, and of the sixth.
const CENTRAL: [[f64; 4]; 2] =
    [[4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0], [3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0, 0.0]];
/// Weights of the values at 0, 1, 2, … steps: of the eighth order, and of the seventh.
const ONE_SIDED: [[f64; 9]; 2] = [
    [-761.0 / 280.0, 8.0, -14.0, 56.0 / 3.0, -35.0 / 2.0, 56.0 / 5.0, -14.0 / 3.0, 8.0 / 7.0, -1.0 / 8.0],
    [-363.0 / 140.0, 7.0, -21.0 / 2.0, 35.0 / 3.0, -35.0 / 4.0, 21.0 / 5.0, -7.0 / 6.0, 1.0 / 7.0, 0.0],
];

/// A scene as it begins: what decides how it runs, and its numbers.
pub struct Start {
    /// as [`Scene::structure`]
    structure: Identity,
    numbers: Vec<f64>,
    /// curves that ports are given, which carry no derivatives
    gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// stretches of numbers of one kind: one that is small beside the others is known to the digits of these
    alike: Vec<Range<usize>>,
}

impl Start {
    /// The structure of a scene; its numbers are 0 afterwards.
    pub fn of(scene: &mut Scene) -> Start {
        let mut numbers = Vec::new();
        scene::numbers(scene, &mut |v| numbers.push(*v));
        // as `scene::numbers` has them: lengths and directions in space, elongations, places, shares in modes, their couplings
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

    /// True where all numbers lie on lines through what they are, but for rounding: of one step and of two, up and down.
    fn are_lines(&self, steps: &[[Vec<f64>; 2]]) -> bool {
        let [[up, down], [up2, down2]] = steps else { return false };
        let line = |i: usize| {
            let (v, most) = (self.numbers[i], up2[i].abs().max(down2[i].abs()).max(self.numbers[i].abs()));
            let off = |a: f64, b: f64| ((a - v) - b).abs() <= 8.0 * ROUNDING * most;
            off(up[i], v - down[i]) && off(up2[i], 2.0 * (up[i] - v)) && off(down2[i], 2.0 * (down[i] - v))
        };
        (0..self.numbers.len()).all(line)
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }
}

/// Why one step gives no derivative.
enum Obstacle {
    /// the model has an error there, such as a number out of range
    Model(String),
    Built,
    /// what ports are given is another
    Gesture,
    Rough,
}

/// The derivatives of the numbers of `start` by `parameter`; `compiled` is the start of the model with another value of it.
pub fn derivatives(
    start: &Start,
    parameter: &Parameter,
    compiled: &dyn Fn(f64) -> Result<Start, String>,
) -> Result<Vec<f64>, Error> {
    let (mut obstacle, size) = (Obstacle::Rough, size(parameter));
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut narrow: Option<(f64, Found)> = None;
    for (i, part) in STEPS.into_iter().enumerate() {
        // what was built otherwise by a narrow step is so by a wide one
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
        Obstacle::Model(what) => format!("`{name}` cannot be moved either way from its value: {what}"),
        Obstacle::Built => {
            format!(
                "`{name}` changes what is built, and not only its numbers, so that there is no derivative by it; a number that is 0 may be left out of what is built: write a small one"
            )
        }
        Obstacle::Gesture => {
            format!("`{name}` moves a gesture of the model, and what ports are given is not differentiated")
        }
        Obstacle::Rough => format!(
            "what the scene begins with has no derivative by `{name}` at its value: a corner, a jump, or nothing but rounding"
        ),
    }))
}

/// What steps are parts of, as a power of two: the value, or for 0 a thousandth of the unit.
fn size(parameter: &Parameter) -> f64 {
    let size = if parameter.value == 0.0 { 1e-3 } else { parameter.value.abs() };
    size.log2().round().exp2()
}

/// Differences of two orders, with their step.
struct Found {
    h: f64,
    high: Vec<f64>,
    low: Vec<f64>,
    /// the largest size of each number
    most: Vec<f64>,
    /// its largest change
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
            // what does not change is nothing, whatever the weights round to
            let change = v - base;
            self.high[i] += weights[0] * change;
            self.low[i] += weights[1] * change;
            self.most[i] = self.most[i].max(v.abs());
            self.change[i] = self.change[i].max(change.abs());
        }
    }

    /// True where other derivatives agree with these to this part, and are not 0 where these are known not to be.
    fn may_be(&self, other: &[f64], near: f64) -> bool {
        let largest = self.largest();
        let agree = |(i, by): (usize, &f64)| {
            let apart = (self.high[i] - by * self.h).abs();
            let lost = *by == 0.0 && self.high[i] != 0.0 && self.is_resolved(i);
            !lost && apart <= near * (self.change[i] + largest * self.most[i]) + NOTHING
        };
        other.iter().enumerate().all(agree)
    }

    /// How far a difference may be off.
    fn off(&self, i: usize) -> f64 {
        (self.high[i] - self.low[i]).abs() + ROUNDING * self.most[i]
    }

    /// True where it is well above that.
    fn is_resolved(&self, i: usize) -> bool {
        self.off(i) <= 1e-4 * self.change[i]
    }

    /// The largest change of those, in parts of the number.
    fn largest(&self) -> f64 {
        let resolved = (0..self.high.len()).filter(|i| self.change[*i] > 0.0 && self.is_resolved(*i));
        resolved.map(|i| self.change[i] / self.most[i]).fold(0.0, f64::max)
    }

    /// How far the derivatives are off, and these. Each is measured by the change of its number, and by that which would be as
    /// large a part of it as the largest of all that are well resolved: what changes no more than by rounding is then no matter.
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
        // a non-finite value is as wrong as can be
        let worst = worst.fold(0.0, |most: f64, v| if v <= most { most } else { v });
        let none = |i: usize| !self.is_resolved(i) && self.change[i] <= NOTHING;
        let derivatives = all.map(|i| if none(i) { 0.0 } else { self.high[i] / self.h }).collect();
        (if worst.is_nan() { f64::INFINITY } else { worst }, derivatives)
    }
}

/// By values on both sides. Four of them are enough where all numbers lie on lines, as they do for most parameters.
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

/// By values on one.
fn one_sided(start: &Start, at: &dyn Fn(i32) -> Result<Vec<f64>, Obstacle>, h: f64) -> Result<Found, Obstacle> {
    let mut found = Found::new(start, h);
    let [high, low] = ONE_SIDED;
    for ((steps, high), low) in (0..).zip(high).zip(low).skip(1) {
        found.add(&at(steps)?, &start.numbers, [high, low]);
    }
    Ok(found)
}
