//! Equivalence: how large and how heavy the simulated world is in the hand.
//!
//! Decides for the table of ICMC 2013 (6.3, 6.4; docs/numerics.md §6). A device puts X = α·x into the model and
//! gets f = β·F back; everything else follows: a quantity of dimension lengthᵃ forceᵇ timeᶜ is α⁻ᵃ βᵇ Teᶜ times as
//! large in the hand as in the model, so the exponents of a row come from its dimension and no table of them can be
//! wrong in one place. Te is the unit of time of the model's numbers: 1 s, or a sample of the reference rate in `alg`
//! units. Nobody needs α or β: two rows of different classes, as pairs "real = simulated", settle both; one row settles
//! them where another class is held (the anchor, a padlock on its row). The alternative, two gains in the file, would
//! make an author compute what the table shows.
//!
//! Nothing of it reaches the tick: the result is a pair of [`Gains`] for each device key.

use crate::kind::{Dim, Unit};
use alloc::string::String;
use alloc::vec::Vec;

/// Between the real and the simulated world, for one degree of freedom.
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
    /// Real joules per simulated joule.
    pub fn energy(self) -> f64 {
        self.beta / self.alpha
    }
    /// Real N/m per simulated N/m.
    pub fn stiffness(self) -> f64 {
        self.alpha * self.beta
    }
    /// True where both are numbers a device can work with.
    fn sane(self) -> bool {
        [self.alpha, self.beta, self.stiffness(), self.energy()].iter().all(|v| (1e-30..=1e30).contains(v))
    }
}

/// What a row hangs on: rows of one class are one equivalence said twice.
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
    /// neither: the clock decides
    Time,
}

impl Class {
    /// Its name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Class::Position => "position",
            Class::Force => "force",
            Class::Impedance => "impedance",
            Class::Energy => "energy",
            Class::Time => "time",
        }
    }
    /// A row that stands for it.
    pub fn row(self) -> &'static Quantity {
        let name = if self == Class::Impedance { "stiffness" } else { self.name() };
        ROWS.iter().find(|r| r.name == name).unwrap_or(&ROWS[0])
    }
    /// The class a word means: the name of a row, or `impedance`.
    pub fn of(word: &str) -> Option<Class> {
        if word == "impedance" { Some(Class::Impedance) } else { row(word).map(Quantity::class) }
    }
}

/// A quantity that has an equivalence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// its name in a model file
    pub name: &'static str,
    /// unit of the real side
    pub unit: Unit,
}

/// The table, in the order it is shown.
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

/// The row of this name.
pub fn row(name: &str) -> Option<&'static Quantity> {
    ROWS.iter().find(|r| r.name == name)
}

impl Quantity {
    /// Exponents (p, q, s): real/simulated = αᵖ βᑫ Teˢ.
    pub fn exponents(&self) -> [i32; 3] {
        // length^(m−kg) force^kg time^(s+2kg) is m^m kg^kg s^s
        let Dim { m, kg, s } = self.unit.dim;
        [(kg - m) as i32, kg as i32, (s + 2.0 * kg) as i32]
    }
    /// What it hangs on.
    pub fn class(&self) -> Class {
        match self.exponents() {
            [0, 0, _] => Class::Time,
            [_, 0, _] => Class::Position,
            [0, _, _] => Class::Force,
            [p, q, _] if p == q => Class::Impedance,
            _ => Class::Energy,
        }
    }
    /// Real over simulated, for a model whose unit of time is `time_unit` seconds.
    pub fn factor(&self, g: Gains, time_unit: f64) -> f64 {
        let [p, q, s] = self.exponents();
        power(g.alpha, p) * power(g.beta, q) * power(time_unit, s)
    }
}

/// An equivalence: so much of `row` in the hand \[SI\] per 1 of it in the model's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// the quantity
    pub row: &'static Quantity,
    /// real over simulated
    pub ratio: f64,
}

/// The gains that make both pairs true. `None` for rows of one class, for time, and beyond all numbers.
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
    // of α and β alone: ln rᵢ = pᵢ ln α + qᵢ ln β
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

/// The gains that make one pair true and keep what `anchor` stands for as it is in `held`.
pub fn keep(pair: Pair, anchor: Class, held: Gains, time_unit: f64) -> Option<Gains> {
    let row = anchor.row();
    solve([pair, Pair { row, ratio: row.factor(held, time_unit) }], time_unit)
}

/// What stays when a row of this class is edited and nobody said anything: the travel of the key; where that is what
/// is edited, the feel.
pub fn anchor_for(edited: Class) -> Class {
    if edited == Class::Position { Class::Impedance } else { Class::Position }
}

/// How a device key differs from the others.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Scale {
    /// name of the TGR
    pub key: String,
    /// its α over that of the whole
    pub position: f64,
    /// its β over that of the whole
    pub force: f64,
}

impl Scale {
    /// A lever keeps energy; anything else makes energy given at this key more or less than that given at others.
    pub fn is_lever(&self) -> bool {
        self.position == self.force
    }
}

/// The equivalence of a model.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Equivalence {
    /// of the whole
    pub gains: Gains,
    /// unit of time of the model's numbers \[s\]: 1, or a sample of the reference rate in `alg` units
    pub time_unit: f64,
    /// the anchor written in the model
    pub anchor: Option<Class>,
    /// keys that differ, in the order of the document
    pub keys: Vec<Scale>,
}

impl Default for Equivalence {
    fn default() -> Equivalence {
        Equivalence { gains: Gains::default(), time_unit: 1.0, anchor: None, keys: Vec::new() }
    }
}

impl Equivalence {
    /// The gains of a key, by the name of its TGR.
    pub fn of(&self, key: &str) -> Gains {
        let Gains { alpha, beta } = self.gains;
        match self.keys.iter().find(|k| k.key == key) {
            Some(k) => Gains { alpha: alpha * k.position, beta: beta * k.force },
            None => self.gains,
        }
    }
}

/// v to a small whole power.
fn power(v: f64, n: i32) -> f64 {
    let whole = (0..n.unsigned_abs()).fold(1.0, |a, _| a * v);
    if n < 0 { 1.0 / whole } else { whole }
}
