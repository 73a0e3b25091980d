//! Equivalence: size and weight of the simulated world at a device.
//!
//! It follows the table of ICMC 2013 (6.3, 6.4; docs/numerics.md §6). A device puts X = α·x into the model and gets f =
//! β·F back. A quantity of dimension lengthᵃ forceᵇ timeᶜ is then α⁻ᵃ βᵇ Teᶜ times as large at the device as in the
//! model. The exponents of each row are computed from its dimension, so the table cannot be wrong in one place. Te is
//! the unit of time of the model's numbers: 1 s, or a sample of the reference rate in `alg` units.
//!
//! Authors do not need α or β. Two rows of different classes, as pairs "real = simulated", determine both. One row
//! determines them if another class is held (the anchor, shown as a padlock on its row). Two gains in the file instead
//! would make the author compute what the table shows.
//!
//! The tick does not use the equivalence. Its result is a pair of [`Gains`] for each device key.

use crate::kind::{Dim, Unit};
use alloc::string::String;
use alloc::vec::Vec;

/// Gains between the real and the simulated world, for one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Gains {
    /// simulated metres per real metre
    pub alpha: f64,
    /// real newtons per simulated newton
    pub beta: f64,
}

impl Default for Gains {
    fn default() -> Gains {
        Gains { alpha: 1.0, beta: 1.0 }
    }
}

impl Gains {
    /// Returns real joules per simulated joule.
    pub fn energy(self) -> f64 {
        self.beta / self.alpha
    }
    /// Returns real N/m per simulated N/m.
    pub fn stiffness(self) -> f64 {
        self.alpha * self.beta
    }
    fn sane(self) -> bool {
        [self.alpha, self.beta, self.stiffness(), self.energy()].iter().all(|v| (1e-30..=1e30).contains(v))
    }
}

/// Class of a row, by the gain it depends on. Rows of one class state the same equivalence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Class {
    /// α
    Position,
    /// β
    Force,
    /// αβ
    Impedance,
    /// β/α
    Energy,
    /// neither gain: fixed by the clock
    Time,
}

impl Class {
    /// Returns the name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Class::Position => "position",
            Class::Force => "force",
            Class::Impedance => "impedance",
            Class::Energy => "energy",
            Class::Time => "time",
        }
    }
    /// Returns a row that represents the class.
    pub fn row(self) -> &'static Quantity {
        let name = if self == Class::Impedance { "stiffness" } else { self.name() };
        ROWS.iter().find(|r| r.name == name).unwrap_or(&ROWS[0])
    }
    /// Returns the class of a word: the name of a row, or `impedance`.
    pub fn of(word: &str) -> Option<Class> {
        if word == "impedance" { Some(Class::Impedance) } else { row(word).map(Quantity::class) }
    }
}

/// A quantity with an equivalence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// name in a model file
    pub name: &'static str,
    /// unit of the real side
    pub unit: Unit,
}

/// The rows of the table, in order of display.
pub const ROWS: &[Quantity] = &[
    Quantity { name: "position", unit: Unit::METRE },
    Quantity { name: "velocity", unit: Unit::SPEED },
    Quantity { name: "acceleration", unit: Unit::ACCELERATION },
    Quantity { name: "force", unit: Unit::NEWTON },
    Quantity { name: "momentum", unit: Unit::MOMENTUM },
    Quantity { name: "mass", unit: Unit::KILOGRAM },
    Quantity { name: "stiffness", unit: Unit::STIFFNESS },
    Quantity { name: "viscosity", unit: Unit::VISCOSITY },
    Quantity { name: "compliance", unit: Unit::COMPLIANCE },
    Quantity { name: "energy", unit: Unit::JOULE },
    Quantity { name: "power", unit: Unit::WATT },
    Quantity { name: "time", unit: Unit::SECOND },
];

/// Returns the row of this name.
pub fn row(name: &str) -> Option<&'static Quantity> {
    ROWS.iter().find(|r| r.name == name)
}

impl Quantity {
    /// Returns the exponents (p, q, s) of real/simulated = αᵖ βᑫ Teˢ.
    pub fn exponents(&self) -> [i32; 3] {
        // length^(m−kg) force^kg time^(s+2kg) is m^m kg^kg s^s
        let Dim { m, kg, s } = self.unit.dim;
        [(kg - m) as i32, kg as i32, (s + 2.0 * kg) as i32]
    }
    /// Returns the class.
    pub fn class(&self) -> Class {
        match self.exponents() {
            [0, 0, _] => Class::Time,
            [_, 0, _] => Class::Position,
            [0, _, _] => Class::Force,
            [p, q, _] if p == q => Class::Impedance,
            _ => Class::Energy,
        }
    }
    /// Returns real over simulated, for a model whose unit of time is `time_unit` seconds.
    pub fn factor(&self, g: Gains, time_unit: f64) -> f64 {
        let [p, q, s] = self.exponents();
        power(g.alpha, p) * power(g.beta, q) * power(time_unit, s)
    }
}

/// An equivalence: the amount of `row` at the device \[SI\] per 1 in the model's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// quantity
    pub row: &'static Quantity,
    /// real over simulated
    pub ratio: f64,
}

/// Returns the gains that satisfy both pairs, or `None` for rows of one class, for time, and for gains out of range.
///
/// ```
/// use ca_core::equivalence::{Pair, row, solve};
/// let time_unit = 1.0 / 44_100.0;
/// let mass = Pair { row: row("mass").unwrap(), ratio: 0.02 }; // 20 g is 1.0
/// let place = Pair { row: row("position").unwrap(), ratio: 0.02 }; // 20 mm is 1
/// let g = solve([mass, place], time_unit).unwrap();
/// assert!((g.alpha - 50.0).abs() < 1e-12 && (g.beta - 777_924.0).abs() < 1e-6);
/// ```
pub fn solve(pairs: [Pair; 2], time_unit: f64) -> Option<Gains> {
    // in α and β alone: ln rᵢ = pᵢ ln α + qᵢ ln β
    let [(p1, q1, r1), (p2, q2, r2)] = pairs.map(|e| {
        let [p, q, s] = e.row.exponents();
        (p, q, e.ratio / power(time_unit, s))
    });
    let det = p1 * q2 - p2 * q1;
    let root = |v: f64| match det {
        1 => v,
        -1 => 1.0 / v,
        2 => libm::sqrt(v),
        _ => 1.0 / libm::sqrt(v),
    };
    let g = Gains { alpha: root(power(r1, q2) * power(r2, -q1)), beta: root(power(r2, p1) * power(r1, -p2)) };
    (det != 0 && g.sane()).then_some(g)
}

/// Returns the gains that satisfy one pair and keep the quantity of `anchor` as in `held`.
pub fn solve_keeping(pair: Pair, anchor: Class, held: Gains, time_unit: f64) -> Option<Gains> {
    let row = anchor.row();
    solve([pair, Pair { row, ratio: row.factor(held, time_unit) }], time_unit)
}

/// Returns the class held by default when a row of this class is edited: the position, or for the position the
/// impedance.
pub fn anchor_for(edited: Class) -> Class {
    if edited == Class::Position { Class::Impedance } else { Class::Position }
}

/// Difference of a device key from the others.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Scale {
    /// name of the TGR
    pub key: String,
    /// α of the key relative to the model
    pub position: f64,
    /// β of the key relative to the model
    pub force: f64,
}

impl Scale {
    /// Returns true if the key is a lever, which conserves energy. Otherwise its energy has another scale than at other
    /// keys.
    pub fn is_lever(&self) -> bool {
        self.position == self.force
    }
}

/// Equivalence of a model.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Equivalence {
    /// gains of the whole model
    pub gains: Gains,
    /// unit of time of the model's numbers \[s\]: 1, or a sample of the reference rate in `alg` units
    pub time_unit: f64,
    /// anchor written in the model
    pub anchor: Option<Class>,
    /// keys that differ, in document order
    pub keys: Vec<Scale>,
}

impl Default for Equivalence {
    fn default() -> Equivalence {
        Equivalence { gains: Gains::default(), time_unit: 1.0, anchor: None, keys: Vec::new() }
    }
}

impl Equivalence {
    /// Returns the gains of a key, by the name of its TGR.
    pub fn of(&self, key: &str) -> Gains {
        let Gains { alpha, beta } = self.gains;
        match self.keys.iter().find(|k| k.key == key) {
            Some(k) => Gains { alpha: alpha * k.position, beta: beta * k.force },
            None => self.gains,
        }
    }
}

fn power(v: f64, n: i32) -> f64 {
    let whole = (0..n.unsigned_abs()).fold(1.0, |a, _| a * v);
    if n < 0 { 1.0 / whole } else { whole }
}
