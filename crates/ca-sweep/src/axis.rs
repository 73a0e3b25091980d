//! Axes of a sweep, and the position of a run on them.
//!
//! The position of a run on an axis depends only on the scene, the seed, the index of the run and the name of the axis.
//! It does not depend on which worker computes it, in which order, or on the other axes. With `‖` for concatenation of
//! bytes, and numbers as 8 little-endian bytes:
//!
//! - Seed of run i: the first 8 bytes of BLAKE3(hash of the scene, 32 bytes ‖ seed ‖ i) as a number, halved to fit a
//!   column of signed integers.
//! - Position of run i on an axis, in [0, 1): the first 8 bytes of BLAKE3(seed of run i ‖ name), upper 53 bits over
//!   2⁵³.

use ca_lab::Failure;
use ca_model::Value;
use ca_model::quantity;

/// Maximum number of values on an axis.
const MOST: usize = 1_000_000;

/// Values that a parameter may have.
#[derive(Clone, Debug, PartialEq)]
pub enum Space {
    /// One of these values.
    List(Vec<Value>),
    /// Any value between two, in SI units.
    Range {
        /// One end.
        from: f64,
        /// The other end.
        to: f64,
        /// Equal ratios instead of equal differences.
        log: bool,
    },
}

/// Parameter and its possible values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name in the syntax of `--set`.
    pub name: String,
    /// Possible values.
    pub space: Space,
    /// Both ends of a range as written, with their units.
    pub ends: Option<[Value; 2]>,
}

impl Axis {
    /// Makes an axis from a list of values.
    ///
    /// # Errors
    /// [`Failure::Usage`] where there are none, or too many.
    pub fn list(name: &str, values: Vec<Value>) -> Result<Axis, Failure> {
        if values.is_empty() || values.len() > MOST {
            return Err(Failure::Usage(format!("`{name}` has {} values; 1 to {MOST} are allowed", values.len())));
        }
        Ok(Axis { name: name.into(), space: Space::List(values), ends: None })
    }

    /// Makes an axis from one number or quantity to another: `steps` values, or any value between.
    ///
    /// # Errors
    /// [`Failure::Usage`] where the ends are not numbers, or have different signs with `log`.
    pub fn range(name: &str, ends: [Value; 2], log: bool, steps: Option<u64>) -> Result<Axis, Failure> {
        let usage = |what: String| Err(Failure::Usage(format!("`{name}` {what}")));
        let [Some(from), Some(to)] = [ends[0].number(), ends[1].number()] else {
            return usage("needs a number or a quantity at both ends of its range".into());
        };
        if !(from.is_finite() && to.is_finite() && (to - from).is_finite()) {
            return usage(format!("goes from {from} to {to}; both ends and their difference must be finite"));
        }
        if log && !(from * to > 0.0 && (to / from).is_finite()) {
            return usage(format!("goes from {from} to {to} with `log`; both ends must be above 0, or both below"));
        }
        let Some(steps) = steps else {
            return Ok(Axis { name: name.into(), space: Space::Range { from, to, log }, ends: Some(ends) });
        };
        if !(2..=MOST as u64).contains(&steps) {
            return usage(format!("has {steps} steps; 2 to {MOST} are allowed"));
        }
        let at = |k: u64| if k == steps - 1 { to } else { between(from, to, log, k as f64 / (steps - 1) as f64) };
        let values = (0..steps).map(|k| Value::Num(at(k))).collect();
        Ok(Axis { name: name.into(), space: Space::List(values), ends: Some(ends) })
    }

    /// Value at position `u` in [0, 1).
    pub fn at(&self, u: f64) -> Value {
        match &self.space {
            Space::List(values) => values[((u * values.len() as f64) as usize).min(values.len() - 1)].clone(),
            Space::Range { from, to, log } => Value::Num(between(*from, *to, *log, u)),
        }
    }

    /// Formats a value on the axis: six digits and the unit if the axis goes from one quantity to another.
    pub fn shown(&self, value: &Value) -> String {
        let (Value::Num(v), Some([from, to])) = (value, &self.ends) else { return value.shown() };
        let dim = |end: &Value| match end {
            Value::Text(t) => quantity::parse(t).ok().filter(|q| q.has_unit).map(|q| q.dim),
            _ => None,
        };
        let unit = dim(from).or_else(|| dim(to)).map(quantity::unit_of).unwrap_or_default();
        format!("{} {unit}", quantity::Plain(quantity::six(*v))).trim_end().to_owned()
    }

    /// Number of values; `None` for a range.
    pub fn count(&self) -> Option<u64> {
        match &self.space {
            Space::List(values) => Some(values.len() as u64),
            Space::Range { .. } => None,
        }
    }

    /// Returns whether all values are numbers.
    pub fn is_numeric(&self) -> bool {
        match &self.space {
            Space::List(values) => values.iter().all(|v| v.number().is_some()),
            Space::Range { .. } => true,
        }
    }
}

fn between(from: f64, to: f64, log: bool, u: f64) -> f64 {
    // libm gives the same bits on every machine
    if log { from * libm::pow(to / from, u) } else { from + (to - from) * u }
}

fn word(parts: &[&[u8]]) -> u64 {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(part);
    }
    let hash = hasher.finalize();
    hash.as_bytes().first_chunk().map_or(0, |b| u64::from_le_bytes(*b))
}

/// Seed of a run.
pub fn seed(scene: &blake3::Hash, seed: u64, index: u64) -> u64 {
    word(&[scene.as_bytes(), &seed.to_le_bytes(), &index.to_le_bytes()]) >> 1
}

/// Position of the run with this seed on the axis of this name, in [0, 1).
pub fn place(seed: u64, name: &str) -> f64 {
    (word(&[&seed.to_le_bytes(), name.as_bytes()]) >> 11) as f64 * 2f64.powi(-53)
}
