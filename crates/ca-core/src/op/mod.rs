//! Op: one homogeneous pass over many modules.
//!
//! A compiled layout is a flat list of records, each with a plain function that was chosen once, at load
//! (the law, the form, with or without offsets and taps). [`Pass`] and the law say which function that is, so that a scene can be
//! bound to another number. The law of links has their kernels, also a law of another crate (LPR).

use crate::law::{Bound, Force, Idle, Start, Steepest};
use crate::numeric::{Real, Table};
use crate::state::State;
use alloc::vec::Vec;

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
pub use layout::{MeasureKind, Ports, Way};
pub use links::law::{family, loaded, started};
pub use wide::Vectors;

/// One pass, run once per tick.
pub type Kernel<R = f64> = fn(&Op<R>, &Layout<R>, &mut State<R>);

/// Whether a run of links integrates the masses of its row too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
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
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
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

/// The work of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Pass {
    /// the law of its links
    Links,
    /// position ports
    Enx,
    /// device ports: how their position comes in, and whether late
    DevicesIn(Way, bool),
    /// positions of masses that go by their modes
    ModalPorts,
    /// parameters that ports drive
    Driven,
    /// positions of moving points
    Points,
    /// the energy ledger of the tick before
    Ledger,
    /// coefficients on their way
    Changes,
    /// cells under moving points
    Aim,
    /// the energy ledger after changes
    LedgerOfChanges,
    /// force ports; `counted` where refused inputs are counted
    Enf {
        /// see above
        counted: bool,
    },
    /// weight
    Weight,
    /// waves that arrive
    WavesIn,
    /// forces on moving points
    PointsBack,
    /// forces on masses that go by their modes
    Modes,
    /// implicit links, as one system
    Implicit,
    /// implicit links that share no mass
    ImplicitPairs,
    /// before links that count on the motion to come, at masses that go by their modes
    ModesAhead,
    /// contacts that are solved together; `modes` where masses of one group are coupled
    Contacts {
        /// see above
        modes: bool,
    },
    /// behind them
    ModesAgain,
    /// sends no force to devices
    Mute,
    /// forces on device ports
    DevicesOut(Way),
    /// the energy ledger of the border
    LedgerOfBorder(Way),
    /// keeps what the ledger reads in the next tick
    LedgerOfForces,
    /// groups at the gesture rate
    Group {
        /// whether their border is compensated
        compensated: bool,
    },
    /// forces on them
    GroupOut {
        /// whether their border is compensated
        compensated: bool,
    },
    /// forces of links of fused passes that are heard
    HeardLinks,
    /// outputs one by one
    Outputs,
    /// outputs summed in lanes
    ManyOutputs,
    /// outputs of one position each
    Positions,
    /// outputs of motion
    Motions,
    /// outputs with a high pass
    HighPass,
    /// outputs of motion with a high pass
    HighPassOfMotion,
    /// the low pass of the channels
    LowPass,
    /// its past, at a tick between two samples
    Remember,
    /// integrates masses that only have inertia
    IntegrateFree,
    /// integrates masses that have a spring and a damper to the ground
    IntegrateFull,
    /// waves that leave
    WavesOut,
    /// clears denormal numbers
    Flush,
    /// a drift of `pefrl`
    Drift,
    /// a kick of `pefrl`
    Kick {
        /// with springs of cells
        own: bool,
    },
    /// inputs of a sample with several ticks
    Inputs,
    /// the ticks between two samples
    Between,
    /// from here on the state counts ticks
    ToTicks,
    /// from here on the state counts samples
    ToSamples,
}

impl Pass {
    /// Its name in the schedule; for links, the name of their law.
    pub fn name(self) -> &'static str {
        match self {
            Pass::Links => "links",
            Pass::Enx => "ENX",
            Pass::DevicesIn(..) => "TGR in",
            Pass::ModalPorts => "modal ports",
            Pass::Driven => "driven",
            Pass::Points => "points",
            Pass::Ledger => "ledger",
            Pass::Changes => "changes",
            Pass::Aim => "aim",
            Pass::LedgerOfChanges => "ledger of changes",
            Pass::Enf { .. } => "ENF",
            Pass::Weight => "weight",
            Pass::WavesIn => "waves in",
            Pass::PointsBack => "points back",
            Pass::Modes => "modes",
            Pass::Implicit => "implicit",
            Pass::ImplicitPairs => "implicit pairs",
            Pass::ModesAhead => "modes ahead",
            Pass::Contacts { .. } => "contacts",
            Pass::ModesAgain => "modes again",
            Pass::Mute => "TGR mute",
            Pass::DevicesOut(_) => "TGR out",
            Pass::LedgerOfBorder(_) => "ledger of the border",
            Pass::LedgerOfForces => "ledger of forces",
            Pass::Group { .. } => "gesture group",
            Pass::GroupOut { .. } => "gesture group out",
            Pass::HeardLinks => "heard links",
            Pass::Outputs | Pass::ManyOutputs | Pass::Positions => "outputs",
            Pass::Motions => "outputs of motion",
            Pass::HighPass => "high pass",
            Pass::HighPassOfMotion => "high pass of motion",
            Pass::LowPass | Pass::Remember => "low pass",
            Pass::IntegrateFree => "integrate MAS",
            Pass::IntegrateFull => "integrate CEL",
            Pass::WavesOut => "waves out",
            Pass::Flush => "flush",
            Pass::Drift => "drift",
            Pass::Kick { .. } => "kick",
            Pass::Inputs => "inputs",
            Pass::Between => "ticks between",
            Pass::ToTicks => "to ticks",
            Pass::ToSamples => "to samples",
        }
    }
}

/// A pass and where its modules stand.
#[derive(Clone, Copy)]
pub struct Op<R: Real = f64> {
    /// what to run
    pub kernel: Kernel<R>,
    /// which kernel that is
    pub pass: Pass,
    /// what it is, for people: the code of a law, or [`Pass::name`]
    pub name: &'static str,
    /// the law, for links
    pub law: Option<&'static Law>,
    /// its functions over the number of the tick
    pub fns: Option<LawFns<R>>,
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

impl<R: Real> Op<R> {
    /// A pass without links, which has the `kernel` of `pass`.
    pub fn new(pass: Pass, kernel: Kernel<R>, n: usize) -> Op<R> {
        let (form, ports, name) = (Form::default(), Ports::default(), pass.name());
        Op { kernel, pass, name, law: None, fns: None, form, ports, n, first: 0, mat: 0, coef: 0, mem: 0, tap: 0 }
    }

    /// A batch of `n` links of a law, whose functions over `R` are `fns`.
    pub fn links(law: &'static Law, fns: LawFns<R>, form: Form, n: usize) -> Op<R> {
        Op { name: law.code, law: Some(law), fns: Some(fns), form, ..Op::new(Pass::Links, (fns.kernel)(form), n) }
    }
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
    /// see [`Phi::coefs`](crate::law::Phi::coefs); `out` has [`Law::coefs`] places
    pub load: fn(p: &[Option<f64>], tick_dt: f64, out: &mut [f64]),
    /// see [`Phi::bound`](crate::law::Phi::bound)
    pub bound: fn(c: &[f64], tables: &[Table]) -> Bound,
    /// see [`Phi::steepest`](crate::law::Phi::steepest)
    pub steepest: Steepest,
    /// a cheaper law for these parameters (`None` marks one that may change while playing), if there is one
    pub simpler: fn(p: &[ParamBinding]) -> Option<&'static Law>,
    /// all laws that [`Law::simpler`] may return
    pub variants: &'static [&'static Law],
    /// a table the law needs whatever its parameters; its number is handed over after the last parameter
    pub table: Option<fn() -> Table>,
    /// its functions over `f64`
    pub fns: LawFns,
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
    /// moves the same place. Elsewhere this law runs instead
    Single(&'static Law),
    /// after all others, collected link by link and then computed at once by [`Pass::Contacts`]
    Coupled,
}

impl SolveStage {
    /// True where the force does not depend on the motion that others would cause.
    pub const fn is_explicit(&self) -> bool {
        matches!(self, SolveStage::Explicit)
    }
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
