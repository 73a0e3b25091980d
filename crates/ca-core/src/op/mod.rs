//! Op: one homogeneous pass over many modules.
//!
//! Decides that a compiled layout is a flat list of records, each with a plain function that was chosen once, at load
//! (the law, the form, with or without offsets and taps). A function pointer rather than an enum of passes, because
//! other crates bring passes of their own (LPR), and rather than a boxed trait object, because the record is then plain
//! data that `ca check --schedule` can print.

use crate::law::{Bound, Force, Idle, Steepest};
use crate::numeric::{Real, Table};
use crate::state::State;

pub mod account;
pub mod blocker;
pub mod driven;
pub mod energy;
pub mod heard;
pub mod layout;
pub mod links;
pub mod lowpass;
pub mod pass;
pub mod substep;
pub mod wave;
pub(crate) mod wide;

pub use account::Energies;
use layout::Layout;
pub use layout::{MeasureKind, Ports};
pub use wide::Vectors;

/// One pass, run once per tick.
pub type Kernel = fn(&Op, &Layout, &mut State);

/// Whether a run of links integrates the masses of its row too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrate {
    /// it adds to their forces
    #[default]
    No,
    /// masses that only have inertia
    Mas,
    /// masses with springs and dampers of their own
    Cel,
}

/// Whether one end of all links of a batch is the same place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hub {
    /// it is not
    #[default]
    None,
    /// the first
    First,
    /// the second
    Second,
}

/// What a folded row does with the links across it: those of a mesh, between a mass and that as many places further.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Band {
    /// there are none
    #[default]
    None,
    /// so many places further; those links are the batch that follows, and run in this pass
    Along(usize),
    /// it is those links, and runs in the pass of the batch before
    Across,
}

/// How a batch of links is laid out; chooses the kernel.
// answers to as many questions, any of which may be yes
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Form {
    /// 0: any MATs; else link i joins `mat + i` and `mat + i + stride`
    pub stride: usize,
    /// only for laws in vectors: links join one place to places that follow each other
    pub hub: Hub,
    /// some link of the batch has e₀ ≠ 0
    pub offset: bool,
    /// the force of each link is kept in [`State::tap`]
    pub tap: bool,
    /// how the first port measures
    pub measure: MeasureKind,
    /// how the second port measures, for quadripoles
    pub onto: Option<MeasureKind>,
    /// some link of a batch that measures distances has a softening length
    pub soften: bool,
    /// all pairs of two sets are one module; only for contacts without memory
    pub set: bool,
    /// only for runs of linear laws without memory
    pub integrate: Integrate,
    /// only for runs that integrate, of laws in vectors: masses and links stand in the order of [`Fold`](crate::state::Fold)
    pub folded: bool,
    /// only for those: what links across the row do
    pub band: Band,
}

/// A pass and where its modules stand.
#[derive(Clone, Copy)]
pub struct Op {
    /// what to run
    pub kernel: Kernel,
    /// what it is, for people: the code of a law, or `integrate MAS`, `enx`, …
    pub name: &'static str,
    /// the law, for links
    pub law: Option<&'static Law>,
    /// layout of a batch of links
    pub form: Form,
    /// where the numbers of its ports stand
    pub ports: Ports,
    /// number of modules, and of places in a row that no link takes
    pub n: usize,
    /// first link in [`Layout::ends`], or first entry of whatever list the pass reads
    pub first: usize,
    /// first MAT
    pub mat: usize,
    /// first coefficient in [`State::coef`]; coefficient s of link i is at `coef + s·n + i`
    pub coef: usize,
    /// first number in [`State::mem`]; those of link i start at `mem + i·M`
    pub mem: usize,
    /// first index into [`State::tap`]
    pub tap: usize,
}

impl Op {
    /// A pass without links.
    pub fn pass(name: &'static str, kernel: Kernel, n: usize) -> Op {
        let (form, ports) = (Form::default(), Ports::default());
        Op { kernel, name, law: None, form, ports, n, first: 0, mat: 0, coef: 0, mem: 0, tap: 0 }
    }
}

/// A law as data: the functions of a [`Phi`](crate::law::Phi) over slices, and its kernels.
// answers to as many questions, any of which may be yes
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Copy)]
pub struct Law {
    /// code of the law that runs, e.g. `RES` for a REF without viscosity
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
    /// see [`Phi::coefs`](crate::law::Phi::coefs); `out` has [`Law::coefs`] places
    pub load: fn(p: &[Option<f64>], tick_dt: f64, out: &mut [f64]),
    /// see [`Phi::start`](crate::law::Phi::start)
    pub start: fn(c: &[Real], at: [Real; 2], mem: &mut [Real]),
    /// see [`Phi::force`](crate::law::Phi::force)
    pub force: Force,
    /// what it stores and loses
    pub energies: Energies,
    /// see [`Phi::idle`](crate::law::Phi::idle)
    pub idle: Idle,
    /// see [`Phi::bound`](crate::law::Phi::bound)
    pub bound: fn(c: &[f64], tables: &[Table]) -> Bound,
    /// see [`Phi::steepest`](crate::law::Phi::steepest)
    pub steepest: Steepest,
    /// the pass for one form of the law
    pub kernel: fn(Form) -> Kernel,
    /// a cheaper law for these parameters (`None` marks one that may change while playing), if there is one
    pub simpler: fn(p: &[ParamBinding]) -> Option<&'static Law>,
    /// a table the law needs whatever its parameters; its number is handed over after the last parameter
    pub table: Option<fn() -> Table>,
}

/// When the force of a law is computed among the forces of a tick.
#[derive(Clone, Copy)]
pub enum SolveStage {
    /// from what is known at its beginning
    Explicit,
    /// after all forces of stage `Explicit`, from the motion they would cause: on a line, where no other link of a later stage
    /// moves the same place. Elsewhere this law runs instead
    Single(&'static Law),
    /// after all others, collected link by link and then computed at once by this pass
    Coupled(Kernel),
}

/// What is known of a parameter when a law is specialised.
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
