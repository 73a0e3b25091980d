//! Parameters as data: dimension, unit, range, need and doc of what an author can write.
//!
//! These records do not depend on modules, so that quantities, kinds, generators and the schema can all use them.

/// Exponents of metre, kilogram and second: N/m is `Dim { m: 0.0, kg: 1.0, s: -2.0 }`; Hertz stiffness is N/m^1.5.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Dim {
    /// exponent of the metre
    pub m: f64,
    /// exponent of the kilogram
    pub kg: f64,
    /// exponent of the second
    pub s: f64,
}

impl Dim {
    /// Makes a dimension from its three exponents.
    pub const fn new(m: f64, kg: f64, s: f64) -> Dim {
        Dim { m, kg, s }
    }

    /// Returns true if both are equal to 1e-9, which absorbs the rounding of rational exponents.
    pub fn same(self, other: Dim) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        near(self.m, other.m) && near(self.kg, other.kg) && near(self.s, other.s)
    }
}

/// Returns the factor from `alg` units of a dimension to SI.
///
/// Algorithmic units keep the metre and the newton. Their unit of time is one sample of the reference rate, `tr` \[s\],
/// so a mass unit is tr² kg and a viscosity unit tr N s/m (GENESIS and mi.lib: M = m/T², Z = z/T, K = k).
pub fn alg_to_si(dim: Dim, tr: f64) -> f64 {
    libm::pow(tr, 2.0 * dim.kg + dim.s)
}

/// A unit as authors write it, with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// symbol, e.g. `N s/m`; empty for a plain number
    pub symbol: &'static str,
    /// dimension
    pub dim: Dim,
}

macro_rules! units {
    ($($(#[$doc:meta])* $name:ident = $symbol:literal, $dim:expr;)*) => {
        impl Unit {
            $($(#[$doc])* pub const $name: Unit = Unit { symbol: $symbol, dim: $dim };)*

            #[cfg(feature = "bytes")]
            pub(crate) const NAMED: &[Unit] = &[$(Unit::$name),*];
        }
    };
}
units! {
    /// plain number
    NONE = "", Dim::new(0.0, 0.0, 0.0);
    /// metre
    METRE = "m", Dim::new(1.0, 0.0, 0.0);
    /// kilogram
    KILOGRAM = "kg", Dim::new(0.0, 1.0, 0.0);
    /// second
    SECOND = "s", Dim::new(0.0, 0.0, 1.0);
    /// hertz
    HERTZ = "Hz", Dim::new(0.0, 0.0, -1.0);
    /// metre per second
    SPEED = "m/s", Dim::new(1.0, 0.0, -1.0);
    /// metre per second squared
    ACCELERATION = "m/s^2", Dim::new(1.0, 0.0, -2.0);
    /// newton
    NEWTON = "N", Dim::new(1.0, 1.0, -2.0);
    /// stiffness
    STIFFNESS = "N/m", Dim::new(0.0, 1.0, -2.0);
    /// viscosity
    VISCOSITY = "N s/m", Dim::new(0.0, 1.0, -1.0);
    /// mass per length
    LINEAR_DENSITY = "kg/m", Dim::new(-1.0, 1.0, 0.0);
    /// cubic stiffness
    CUBIC = "N/m^3", Dim::new(-2.0, 1.0, -2.0);
    /// momentum, impulse
    MOMENTUM = "N s", Dim::new(1.0, 1.0, -1.0);
    /// compliance
    COMPLIANCE = "m/N", Dim::new(0.0, -1.0, 2.0);
    /// joule
    JOULE = "J", Dim::new(2.0, 1.0, -2.0);
    /// watt
    WATT = "W", Dim::new(2.0, 1.0, -3.0);
}

impl Unit {
    /// Symbols of power-law stiffness for the exponents 1, 1.25 … 5.
    pub(crate) const POWERS: [&str; 17] = [
        "N/m", "N/m^1.25", "N/m^1.5", "N/m^1.75", "N/m^2", "N/m^2.25", "N/m^2.5", "N/m^2.75", "N/m^3", "N/m^3.25",
        "N/m^3.5", "N/m^3.75", "N/m^4", "N/m^4.25", "N/m^4.5", "N/m^4.75", "N/m^5",
    ];
    pub(crate) const ANY_POWER: &str = "N/m^p";

    /// Returns the unit of power-law stiffness for the exponent `p`, a multiple of 1/4 from 1 to 5.
    pub fn power_stiffness(p: f64) -> Unit {
        let place = libm::round(4.0 * (p - 1.0)).max(0.0) as usize;
        let symbol = Unit::POWERS.get(place).copied().unwrap_or(Unit::ANY_POWER);
        Unit { symbol, dim: Dim::new(1.0 - p, 1.0, -2.0) }
    }
}

/// Requirement for a parameter in a model file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Need {
    /// required
    Required,
    /// has a default, in SI
    Default(f64),
    /// optional without a default; its absence has a meaning (see [`OneOf`] and the doc of the parameter)
    Optional,
}

/// Values that a parameter accepts. `Number` to `Flag` resolve to one `f64` in SI; the others are structured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Type {
    /// a number with a unit, `min ..= max` in SI; may name a `[param]`
    Number {
        /// unit and dimension
        unit: Unit,
        /// smallest value accepted, in SI
        min: f64,
        /// largest value accepted, in SI
        max: f64,
    },
    /// like `Number`, in N/m^p, where p is the value of the sibling parameter named here
    PowerStiffness {
        /// name of the parameter that holds the exponent
        exponent: &'static str,
    },
    /// an integer, `min ..= max`
    Count {
        /// smallest value
        min: u32,
        /// largest value
        max: u32,
    },
    /// one of these words; resolves to its index
    Choice(&'static [&'static str]),
    /// `true` or `false`; resolves to 1 or 0
    Flag,
    /// a list of numbers with a unit, or one number for all
    Numbers {
        /// unit and dimension
        unit: Unit,
        /// smallest value accepted, in SI
        min: f64,
        /// largest value accepted, in SI
        max: f64,
    },
    /// a list of `[x, y]` points, x rising, each column with its unit
    Points {
        /// unit of the first column
        x: Unit,
        /// unit of the second column
        y: Unit,
    },
    /// a position or a velocity: one number on a line, two in a plane, three in space
    Position {
        /// unit and dimension
        unit: Unit,
    },
    /// a direction in space: `"x"`, `"y"`, `"z"`, or a list of two or three numbers that are not all 0
    Direction,
    /// an integer or a list of integers, each `min ..= max`
    Counts {
        /// smallest value
        min: u32,
        /// largest value
        max: u32,
    },
    /// a list of `[i, j]` nodes of a grid, counted from 0, or backwards from −1
    Nodes,
    /// the two ends of a link: a list of two selectors, or of two lists that pair one to one
    Between,
    /// a selector of modules, e.g. `low[3]`
    Module,
    /// a file of points, see [`crate::kind::cloud`]
    File,
    /// a list of positions
    Positions {
        /// unit and dimension
        unit: Unit,
    },
    /// free text
    Text,
    /// mapping of a MIDI note or controller to a port (an inline table, see [`crate::io::midi`])
    Midi,
}

/// One parameter of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// key in a model file
    pub name: &'static str,
    /// what it accepts
    pub ty: Type,
    /// whether it must be written
    pub need: Need,
    /// documentation in one line
    pub doc: &'static str,
    /// whether it may follow a live parameter; false if it determines the structure and not a coefficient
    pub live: bool,
}

impl Param {
    /// Makes a number with unit and range.
    pub const fn number(name: &'static str, unit: Unit, range: (f64, f64), need: Need, doc: &'static str) -> Param {
        Param { name, ty: Type::Number { unit, min: range.0, max: range.1 }, need, doc, live: true }
    }

    /// Makes a parameter of any other type.
    pub const fn new(name: &'static str, ty: Type, need: Need, doc: &'static str) -> Param {
        Param { name, ty, need, doc, live: true }
    }

    /// Makes the parameter fixed, such as a length or a filter, where a change would have no effect.
    #[must_use]
    pub const fn for_good(self) -> Param {
        Param { live: false, ..self }
    }
}

/// Zero and above.
pub const POSITIVE: (f64, f64) = (0.0, f64::MAX);
/// Strictly above zero.
pub const ABOVE_ZERO: (f64, f64) = (f64::MIN_POSITIVE, f64::MAX);
/// Any finite number.
pub const ANY: (f64, f64) = (f64::MIN, f64::MAX);

/// Alternatives: a parameter of one set excludes the other sets. The first name of a set selects it.
#[derive(Clone, Copy, Debug)]
pub struct OneOf {
    /// the sets, e.g. `[["k", "z"], ["f", "t60"]]`
    pub sets: &'static [&'static [&'static str]],
    /// whether one of them must be present
    pub required: bool,
}
