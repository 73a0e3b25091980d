//! A law as data, and its functions in a tick.
//!
//! The compiler and a tick have a record each of a law: that of the tick is made anew for each number that a
//! scene is bound to.

use super::{Energies, Form, Kernel};
use crate::law::{Bound, Force, Idle, Start, Steepest};
use crate::numeric::{Real, Table};
use alloc::vec::Vec;

/// The functions of a law that the compiler calls.
#[derive(Clone, Copy)]
pub struct LoadFns {
    /// see [`Phi::coefs`](crate::law::Phi::coefs); `out` has [`Law::coefs`] places
    pub load: fn(p: &[Option<f64>], tick_dt: f64, out: &mut [f64]),
    /// see [`Phi::bound`](crate::law::Phi::bound)
    pub bound: fn(c: &[f64], tables: &[Table]) -> Bound,
    /// see [`Phi::steepest`](crate::law::Phi::steepest)
    pub steepest: Steepest,
}

/// The cheaper laws that run in place of one, for some of its parameters.
#[derive(Clone, Copy)]
pub struct Cheaper {
    /// a cheaper law for these parameters (`None` marks one that may change while playing), if there is one
    pub simpler: fn(p: &[ParamBinding]) -> Option<&'static Law>,
    /// all laws that [`Cheaper::simpler`] may return
    pub variants: &'static [&'static Law],
}

/// A law as data: what the compiler asks of it. Its functions in the tick are [`LawFns`].
// answers to as many questions, any of which may be yes
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
    /// true where part of its force comes from the time to come, for all such links at once
    pub implicit: bool,
    /// what the compiler calls
    pub at_load: LoadFns,
    /// cheaper laws for some parameters
    pub cheaper: Cheaper,
    /// a table the law needs whatever its parameters; its number is handed over after the last parameter
    pub table: Option<fn() -> Table>,
    /// its functions over `f64`
    pub fns: LawFns,
}

impl Cheaper {
    /// There are none.
    pub const NONE: Cheaper = Cheaper { simpler: |_| None, variants: &[] };
}

/// The functions of a law in a tick over `R`. Those over `f64` are made in the crate of the law, others by [`Laws`] in the crate
/// that binds a scene to `R`.
#[derive(Clone, Copy)]
pub struct LawFns<R: Real = f64> {
    /// see [`Phi::start`](crate::law::Phi::start)
    pub start: Start<R>,
    /// see [`Phi::force`](crate::law::Phi::force)
    pub force: Force<R>,
    /// what it stores and loses
    pub energies: Energies<R>,
    /// see [`Phi::idle`](crate::law::Phi::idle)
    pub idle: Idle<R>,
    /// the pass for one form of the law
    pub kernel: fn(Form) -> Kernel<R>,
}

/// The functions of a law over `R`, behind its code.
pub type LawEntry<R> = (&'static str, LawFns<R>);

/// The functions of laws over `R`, by the code of the law.
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

    /// The functions of a law.
    pub fn get(&self, law: &Law) -> Option<LawFns<R>> {
        self.all.iter().find(|(code, _)| *code == law.code).map(|(_, fns)| *fns)
    }
}

/// When the force of a law is computed among the forces of a tick.
#[derive(Clone, Copy)]
pub enum SolveStage {
    /// from what is known at its beginning
    Explicit,
    /// after all forces of stage `Explicit`, from the motion they would cause: on a line, where no other link of a later stage
    /// moves the same place. Elsewhere one of these laws runs instead
    Single(Together),
    /// after all others, collected link by link and then computed at once by [`Pass::Contacts`](super::Pass::Contacts); of a discrete
    /// gradient, the law that takes its place at masses that go by their modes
    Coupled(Option<&'static Law>),
}

/// The laws that run where a link of [`SolveStage::Single`] may not act alone.
#[derive(Clone, Copy)]
pub struct Together {
    /// on a line and along a direction; none where the law may not share a mass
    pub line: Option<&'static Law>,
    /// in space, and everywhere until arithmetic 5; none where the method is for lines alone
    pub space: Option<&'static Law>,
}

impl Together {
    /// One law for both.
    pub const fn same(law: &'static Law) -> Together {
        Together { line: Some(law), space: Some(law) }
    }
}

impl SolveStage {
    /// True where the force does not depend on the motion that others would cause.
    pub const fn is_explicit(&self) -> bool {
        matches!(self, SolveStage::Explicit)
    }
}

/// The value of a parameter, as far as it is known when a law is specialised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParamBinding {
    /// not written
    Absent,
    /// this value, for good
    At(f64),
    /// may change while playing
    Live,
}

impl ParamBinding {
    /// True where the parameter is nothing and stays so.
    pub fn is_zero(self) -> bool {
        matches!(self, ParamBinding::Absent | ParamBinding::At(0.0))
    }

    /// The value, if it is one for good.
    pub fn number(self) -> Option<f64> {
        if let ParamBinding::At(v) = self { Some(v) } else { None }
    }
}
