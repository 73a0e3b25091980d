//! A law as data, and its functions in a tick.
//!
//! The compiler and the tick have separate records of a law; each number type has its own record of the tick.

use super::{Energies, Form, Kernel};
use crate::law::{Bound, Force, Idle, Start, Steepest};
use crate::numeric::{Real, Table};
use alloc::vec::Vec;

/// Functions of a law that the compiler calls.
#[derive(Clone, Copy)]
pub struct LoadFns {
    /// see [`Phi::coefs`](crate::law::Phi::coefs); `out` holds [`Law::coefs`] numbers
    pub load: fn(p: &[Option<f64>], tick_dt: f64, out: &mut [f64]),
    /// see [`Phi::bound`](crate::law::Phi::bound)
    pub bound: fn(c: &[f64], tables: &[Table]) -> Bound,
    /// see [`Phi::steepest`](crate::law::Phi::steepest)
    pub steepest: Steepest,
}

/// Cheaper laws that replace a law for some of its parameters.
#[derive(Clone, Copy)]
pub struct Cheaper {
    /// returns a cheaper law for these parameters, if there is one
    pub simpler: fn(p: &[ParamBinding]) -> Option<&'static Law>,
    /// all laws that [`Cheaper::simpler`] may return
    pub variants: &'static [&'static Law],
}

/// A law as data for the compiler. Its functions in the tick are [`LawFns`].
// independent flags
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Copy)]
pub struct Law {
    /// code of the law that runs, e.g. `RES` for a REF without viscosity; laws of one code have the same [`LawFns`]
    pub code: &'static str,
    /// coefficients per link
    pub coefs: usize,
    /// numbers of memory per link
    pub mem: usize,
    /// see [`Phi::LINEAR`](crate::law::Phi::LINEAR)
    pub linear: bool,
    /// see [`Phi::WIDE`](crate::law::Phi::WIDE)
    pub wide: bool,
    /// see [`Phi::CONTACT`](crate::law::Phi::CONTACT)
    pub contact: bool,
    /// when its force is computed
    pub stage: SolveStage,
    /// true if part of its force depends on the next positions, solved for all such links at once
    pub implicit: bool,
    /// functions that the compiler calls
    pub at_load: LoadFns,
    /// cheaper laws for some parameters
    pub cheaper: Cheaper,
    /// table that the law needs for any parameters; its index is passed after the last parameter
    pub table: Option<fn() -> Table>,
    /// its functions over `f64`
    pub fns: LawFns,
}

impl Cheaper {
    /// No cheaper laws.
    pub const NONE: Cheaper = Cheaper { simpler: |_| None, variants: &[] };
}

/// Functions of a law in a tick over `R`: over `f64` from the crate of the law, otherwise from [`Laws`].
#[derive(Clone, Copy)]
pub struct LawFns<R: Real = f64> {
    /// see [`Phi::start`](crate::law::Phi::start)
    pub start: Start<R>,
    /// see [`Phi::force`](crate::law::Phi::force)
    pub force: Force<R>,
    /// energy stored and lost
    pub energies: Energies<R>,
    /// see [`Phi::idle`](crate::law::Phi::idle)
    pub idle: Idle<R>,
    /// returns the pass for one form of the law
    pub kernel: fn(Form) -> Kernel<R>,
}

/// Code of a law with its functions over `R`.
pub type LawEntry<R> = (&'static str, LawFns<R>);

/// Functions of laws over `R`, found by the code of the law.
#[derive(Clone, Default)]
pub struct Laws<R: Real> {
    all: Vec<LawEntry<R>>,
}

impl<R: Real> Laws<R> {
    /// Adds the functions of other laws.
    #[must_use]
    pub fn with(mut self, laws: impl IntoIterator<Item = LawEntry<R>>) -> Laws<R> {
        self.all.extend(laws);
        self
    }

    /// Returns the functions of a law.
    pub fn get(&self, law: &Law) -> Option<LawFns<R>> {
        self.all.iter().find(|(code, _)| *code == law.code).map(|(_, fns)| *fns)
    }
}

/// Stage of a tick at which the force of a law is computed.
#[derive(Clone, Copy)]
pub enum SolveStage {
    /// with the other forces, from values known at the beginning of the tick
    Explicit,
    /// after all `Explicit` forces, from the motion they would cause. This holds on a line, where no other link of a
    /// later stage moves the same MAT; elsewhere one of these laws runs instead
    Single(Together),
    /// last, collected and solved at once by [`Pass::Contacts`](super::Pass::Contacts)
    Coupled(Coupled),
}

/// A law that is solved together with others.
#[derive(Clone, Copy)]
pub struct Coupled {
    /// true if its push is a curve over the coming motion, false if it is linear in it
    pub curve: bool,
    /// law for modal masses, if another one
    pub at_modes: Option<&'static Law>,
}

/// Laws that replace a [`SolveStage::Single`] law where it cannot act alone.
#[derive(Clone, Copy)]
pub struct Together {
    /// law on a line and along a direction; none if the law may not share a mass
    pub line: Option<&'static Law>,
    /// law in space, and everywhere in takes up to arithmetic 5; none if the method only works on lines
    pub space: Option<&'static Law>,
}

impl Together {
    /// Makes both the same law.
    pub const fn same(law: &'static Law) -> Together {
        Together { line: Some(law), space: Some(law) }
    }
}

impl SolveStage {
    /// Returns true if the force does not depend on the motion that other forces would cause.
    pub const fn is_explicit(&self) -> bool {
        matches!(self, SolveStage::Explicit)
    }
}

/// What is known of a parameter when a law is specialised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParamBinding {
    /// not specified
    Absent,
    /// fixed at this value
    At(f64),
    /// may change while the scene plays
    Live,
}

impl ParamBinding {
    /// Returns true if the parameter is absent or fixed at zero.
    pub fn is_zero(self) -> bool {
        matches!(self, ParamBinding::Absent | ParamBinding::At(0.0))
    }

    /// Returns the value if it is fixed.
    pub fn number(self) -> Option<f64> {
        if let ParamBinding::At(v) = self { Some(v) } else { None }
    }
}
