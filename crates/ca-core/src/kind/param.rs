//! Parameters as data: dimension, unit, range, need and doc of what an author can write.
//!
//! Decides that these records know nothing of modules, so that quantities, kinds, generators and the schema can all
//! stand on them.

/// Exponents of metre, kilogram and second: `Dim { m: 0.0, kg: 1.0, s: -2.0 }` is N/m. Rational exponents occur
/// (Hertz stiffness is N/m^1.5), hence `f64`.
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
    /// A dimension from its three exponents.
    pub const fn new(m: f64, kg: f64, s: f64) -> Dim {
        Dim { m, kg, s }
    }

    /// True where both are the same to 1e-9, which absorbs the rounding of rational exponents.
    pub fn same(self, other: Dim) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        near(self.m, other.m) && near(self.kg, other.kg) && near(self.s, other.s)
    }
}

/// Factor from `alg` units of a dimension to SI. Algorithmic units keep the metre and the newton and take one sample of the
/// reference rate, `tr` \[s\], as unit of time, so a mass unit is tr² kg and a viscosity unit tr N s/m
/// (GENESIS and mi.lib: M = m/T², Z = z/T, K = k).
pub fn alg_to_si(dim: Dim, tr: f64) -> f64 {
    libm::pow(tr, 2.0 * dim.kg + dim.s)
}

/// A unit as authors read it, with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// e.g. `N s/m`; empty for a plain number
    pub symbol: &'static str,
    /// its dimension
    pub dim: Dim,
}

macro_rules! units {
    ($($(#[$doc:meta])* $name:ident = $symbol:literal, $dim:expr;)*) => {
        impl Unit {
            $($(#[$doc])* pub const $name: Unit = Unit { symbol: $symbol, dim: $dim };)*

            /// All units that have a name here.
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
    /// Symbols of the stiffness of power laws of exponents 1, 1.25 … 5.
    pub(crate) const POWERS: [&str; 17] = [
        "N/m", "N/m^1.25", "N/m^1.5", "N/m^1.75", "N/m^2", "N/m^2.25", "N/m^2.5", "N/m^2.75", "N/m^3", "N/m^3.25",
        "N/m^3.5", "N/m^3.75", "N/m^4", "N/m^4.25", "N/m^4.5", "N/m^4.75", "N/m^5",
    ];
    /// Symbol of the stiffness of a power law of any other exponent.
    pub(crate) const ANY_POWER: &str = "N/m^p";

    /// Stiffness of a power law of exponent `p`, a multiple of 1/4 from 1 to 5.
    pub fn power_stiffness(p: f64) -> Unit {
        let place = libm::round(4.0 * (p - 1.0)).max(0.0) as usize;
        let symbol = Unit::POWERS.get(place).copied().unwrap_or(Unit::ANY_POWER);
        Unit { symbol, dim: Dim::new(1.0 - p, 1.0, -2.0) }
    }
}

/// Whether a number must be written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Need {
    /// must be written
    Required,
    /// may be left out; this value then holds (in SI)
    Default(f64),
    /// may be left out, and its absence means something (see [`OneOf`] and the doc of the parameter)
    Optional,
}

/// What a parameter accepts. `Number` to `Flag` resolve to one `f64` in SI; the others are structure.
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
    /// as `Number`, in N/m^p where p is the value of the sibling parameter named here
    PowerStiffness {
        /// name of the parameter that holds the exponent
        exponent: &'static str,
    },
    /// a whole number, `min ..= max`
    Count {
        /// smallest
        min: u32,
        /// largest
        max: u32,
    },
    /// one of these words; resolves to its index
    Choice(&'static [&'static str]),
    /// `true` or `false`; resolves to 1 or 0
    Flag,
    /// a list of numbers with a unit, or one number that stands for all
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
    /// a place, or a velocity: a number on a line, two in a plane, three in space
    Position {
        /// unit and dimension
        unit: Unit,
    },
    /// a direction in space: `"x"`, `"y"`, `"z"`, or a list of two or three numbers, of any length but 0
    Direction,
    /// a whole number, or a list of them, each `min ..= max`
    Counts {
        /// smallest
        min: u32,
        /// largest
        max: u32,
    },
    /// a list of `[i, j]` nodes of a grid, counted from 0, or from −1 backwards
    Nodes,
    /// the two ends of a link: a list of two selectors, or of two lists that pair one to one
    Between,
    /// a selector of modules, e.g. `low[3]`
    Module,
    /// a file of points, see [`crate::kind::cloud`]
    File,
    /// a list of places
    Positions {
        /// unit and dimension
        unit: Unit,
    },
    /// free text
    Text,
    /// the mapping of a MIDI note or controller onto a port (an inline table, see [`crate::io::midi`])
    Midi,
}

/// One parameter of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Param {
    /// the key in a model file
    pub name: &'static str,
    /// what it accepts
    pub ty: Type,
    /// whether it must be written
    pub need: Need,
    /// one line for people
    pub doc: &'static str,
    /// whether a number may follow a live parameter; not where it decides what is built rather than a coefficient
    pub live: bool,
}

impl Param {
    /// A number with unit and range.
    pub const fn number(name: &'static str, unit: Unit, range: (f64, f64), need: Need, doc: &'static str) -> Param {
        Param { name, ty: Type::Number { unit, min: range.0, max: range.1 }, need, doc, live: true }
    }

    /// A parameter of any other type.
    pub const fn new(name: &'static str, ty: Type, need: Need, doc: &'static str) -> Param {
        Param { name, ty, need, doc, live: true }
    }

    /// The same, but for good: a length or a filter, of which nothing would follow a change.
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

/// Alternatives: parameters of one set exclude those of the others; `required` asks for one set to be there.
/// The first name of a set is what makes it chosen.
#[derive(Clone, Copy, Debug)]
pub struct OneOf {
    /// the sets, e.g. `[["k", "z"], ["f", "t60"]]`
    pub sets: &'static [&'static [&'static str]],
    /// whether one of them must be written
    pub required: bool,
}
