//! Kinds: a module as data, with its code, its parameters with unit, range and doc, and the functions that make it run.
//!
//! One [`Kind`] record holds everything a build knows about a module. The syntax, unit checks, did-you-mean, `ca list`,
//! the JSON Schema, live slots and the conformance suite all walk these records. So a module is one file
//! and one line in the list of its folder (docs/extend.md has what else a law or a generator needs). An enum with a match
//! in every layer would spread one module over ten files.

pub mod builder;
pub mod cloud;
pub mod name;
mod param;

use crate::op::Law;
use builder::Generator;
pub use param::{ABOVE_ZERO, ANY, Dim, Need, OneOf, POSITIVE, Param, Type, Unit, alg_to_si};

/// The three coefficients of a MAT for one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefs {
    /// persistence of the displacement per tick (1 − zT/m)
    pub p: f64,
    /// pull towards rest (−kT²/m)
    pub q: f64,
    /// mobility T²/m \[m/N\]; 0 for a MAT that forces do not move
    pub c: f64,
}

/// Rule by which a kind of MAT gets its coefficients.
#[derive(Clone, Copy)]
pub struct MatSpec {
    /// code of the kind
    pub code: &'static str,
    /// computes them from parameters in SI (in the order of [`Kind::params`]) and the tick, `tick_dt` \[s\]
    pub coefs: fn(params: &[Option<f64>], tick_dt: f64) -> Coefs,
    /// true for a MAT that never moves
    pub fixed: bool,
}

/// Task of a port in each tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortRole {
    /// position in: a MAT moved from outside, once per sound sample
    Enx,
    /// force in: added to the force on a MAT, once per sound sample
    Enf,
    /// position out
    Sox,
    /// force out
    Sof,
    /// one degree of freedom of a device: position in, force out, across the rate border
    Tgr,
}

/// Role of a kind once compiled.
#[derive(Clone, Copy)]
pub enum Role {
    /// material element: three coefficients
    Mat(&'static MatSpec),
    /// interaction between two MATs
    Lia(&'static Law),
    /// connection to the outside
    Port(PortRole),
    /// generator that expands to many modules
    Generator(&'static Generator),
}

/// Everything a build knows about one kind of module.
#[derive(Clone, Copy)]
pub struct Kind {
    /// upper-case code, the section name in a model file
    pub code: &'static str,
    /// title of a few words
    pub title: &'static str,
    /// the law in one line of text
    pub equation: &'static str,
    /// one paragraph of documentation
    pub doc: &'static str,
    /// keys into [`crate::SOURCES`]
    pub source: &'static [&'static str],
    /// parameters, in the order of the documentation
    pub params: &'static [Param],
    /// alternatives among the parameters
    pub one_of: &'static [OneOf],
    /// a complete model file that uses the kind and sounds
    pub example: &'static str,
    /// role once compiled
    pub role: Role,
}

impl Kind {
    /// Returns the position of the parameter `name` in [`Kind::params`].
    pub fn param(&self, name: &str) -> Option<usize> {
        self.params.iter().position(|p| p.name == name)
    }

    /// Returns the position of the parameter `name`, for [`positions!`](crate::positions), at compile time.
    ///
    /// # Panics
    /// At compile time, if the parameter does not exist.
    pub const fn position(&self, name: &str) -> usize {
        let mut i = 0;
        while i < self.params.len() && !same(self.params[i].name.as_bytes(), name.as_bytes()) {
            i += 1;
        }
        assert!(i < self.params.len(), "no parameter of this name in the record");
        i
    }
}

const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

/// Makes a module `at` with the position of each named parameter of a record, such as `p[at::K]` for the parameter `k`.
/// A law thus reads its parameters by name, and a name that the record lacks does not compile.
#[macro_export]
macro_rules! positions {
    ($kind:ident: $($name:ident = $text:literal),+ $(,)?) => {
        /// Positions of the parameters.
        mod at {
            use super::$kind;
            $(pub const $name: usize = $kind.position($text);)+
        }
    };
}

pub(crate) use positions;

impl core::fmt::Debug for Kind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "Kind({})", self.code)
    }
}
