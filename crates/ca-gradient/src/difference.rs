//! Difference: the derivatives of all numbers that a scene begins with, by one parameter.
//!
//! Decides for differences of the eighth order, central ones where the parameter may be moved both ways, with the widest step at which
//! those of a lower order agree: what is smooth is then exact to 1e-12 or so, and what is not (a corner, a jump, a contact that
//! is closed at load on one side only) agrees at no step and is refused. Where a step changes what is built, such as the
//! length of a delay, a narrower one is tried; 1e-5 of the value is the last.

use crate::{Error, Parameter};
use ca_core_dual::numeric::Dual;
use ca_core_dual::scene::Scene;
use ca_core_dual::state::Identity;

/// Steps, in parts of the value.
const STEPS: [f64; 4] = [1e-2, 1e-3, 1e-4, 1e-5];
/// How far differences of both orders may be apart, relative.
const AGREE: f64 = 1e-9;
/// The rounding of a number by the compiler, in parts of itself; with a generous margin.
const ROUNDING: f64 = 1e-12;

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
    structure: Identity,
    pub numbers: Vec<f64>,
}

impl Start {
    pub fn of(mut scene: Scene) -> Start {
        let mut numbers = Vec::new();
        scene.numbers(&mut |v: &mut Dual| numbers.push(v.value()));
        Start { structure: scene.structure(), numbers }
    }
}

/// Why one step gives no derivative.
enum Obstacle {
    /// the model has an error there, such as a number out of range
    Model(String),
    Built,
    Rough,
}

/// The derivatives of the numbers of `start` by `parameter`; `compiled` compiles the model with another value of it.
pub fn derivatives(
    start: &Start,
    parameter: &Parameter,
    compiled: &dyn Fn(f64) -> Result<Scene, String>,
) -> Result<Vec<f64>, Error> {
    let (mut obstacle, size) = (Obstacle::Rough, size(parameter));
    for part in STEPS {
        let h = size * part;
        let at = |k: i32| -> Result<Vec<f64>, Obstacle> {
            let other = Start::of(compiled(parameter.value + f64::from(k) * h).map_err(Obstacle::Model)?);
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
        match found.map(|f| f.checked(size)) {
            Ok(Some(all)) => return Ok(all),
            Ok(None) => obstacle = Obstacle::Rough,
            Err(o) => obstacle = o,
        }
    }
    let name = &parameter.name;
    Err(Error::refused(match obstacle {
        Obstacle::Model(what) => format!("`{name}` cannot be moved either way from its value: {what}"),
        Obstacle::Built => {
            format!(
                "`{name}` changes what is built, and not only its numbers, so that there is no derivative by it; a number that is 0 may be left out of what is built: write a small one"
            )
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
}

impl Found {
    fn new(start: &Start, h: f64) -> Found {
        let none = vec![0.0; start.numbers.len()];
        Found { h, high: none.clone(), low: none, most: start.numbers.iter().map(|v| v.abs()).collect() }
    }

    fn add(&mut self, values: &[f64], base: &[f64], weights: [f64; 2]) {
        for (i, (v, base)) in values.iter().zip(base).enumerate() {
            // what does not change is nothing, whatever the weights round to
            let change = v - base;
            self.high[i] += weights[0] * change;
            self.low[i] += weights[1] * change;
            self.most[i] = self.most[i].max(v.abs());
        }
    }

    /// The derivatives, if both orders agree.
    fn checked(&self, size: f64) -> Option<Vec<f64>> {
        let h = self.h.abs();
        let agree = self.high.iter().zip(&self.low).zip(&self.most).all(|((high, low), most)| {
            let near = AGREE * (high.abs() / h + most / size) + ROUNDING * most / h;
            (high - low).abs() / h <= near
        });
        agree.then(|| self.high.iter().map(|v| v / self.h).collect())
    }
}

/// By values on both sides.
fn central(start: &Start, at: &dyn Fn(i32) -> Result<Vec<f64>, Obstacle>, h: f64) -> Result<Found, Obstacle> {
    let mut found = Found::new(start, h);
    for k in 0..CENTRAL[0].len() {
        let (weights, steps) = ([CENTRAL[0][k], CENTRAL[1][k]], k as i32 + 1);
        found.add(&at(steps)?, &start.numbers, weights);
        found.add(&at(-steps)?, &start.numbers, weights.map(|w| -w));
    }
    Ok(found)
}

/// By values on one.
fn one_sided(start: &Start, at: &dyn Fn(i32) -> Result<Vec<f64>, Obstacle>, h: f64) -> Result<Found, Obstacle> {
    let mut found = Found::new(start, h);
    for k in 1..ONE_SIDED[0].len() {
        found.add(&at(k as i32)?, &start.numbers, [ONE_SIDED[0][k], ONE_SIDED[1][k]]);
    }
    Ok(found)
}
