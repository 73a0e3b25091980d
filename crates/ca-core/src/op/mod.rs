//! Op: one homogeneous pass over many modules.
//!
//! A compiled layout is a flat list of records, each with a plain function that was chosen once, at load
//! (the law, the form, with or without offsets and taps). [`Pass`] and the law say which function that is, so that a scene can be
//! bound to another number. The law of links has their kernels, also a law of another crate (LPR).

use crate::numeric::Real;
use crate::state::State;

pub mod account;
pub mod blocker;
pub mod driven;
pub mod energy;
pub mod heard;
mod law;
pub mod layout;
pub mod links;
pub mod lowpass;
pub mod pass;
pub mod substep;
pub mod wave;
pub(crate) mod wide;

pub use account::Energies;
pub use law::{Cheaper, Law, LawEntry, LawFns, Laws, LoadFns, ParamBinding, SolveStage, Together};
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
    /// the force of each link is kept in [`LinkState::tap`](crate::state::LinkState::tap)
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
    /// ports that run a tick late
    Ahead,
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
            Pass::Ahead => "ports ahead",
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
    /// first link in [`LinkArrays::ends`](layout::LinkArrays::ends), or first entry of whatever list the pass reads
    pub first: usize,
    /// first MAT
    pub mat: usize,
    /// first coefficient in [`State::coef`]; coefficient s of link i is at `coef + s·n + i`
    pub coef: usize,
    /// first number in [`LinkState::mem`](crate::state::LinkState::mem); link i has its own from `mem + i·M` on
    pub mem: usize,
    /// first index into [`LinkState::tap`](crate::state::LinkState::tap)
    pub tap: usize,
}

impl<R: Real> Op<R> {
    /// A pass without links, which has the `kernel` of `pass`.
    pub fn new(pass: Pass, kernel: Kernel<R>, n: usize) -> Op<R> {
        let (form, ports) = (Form::default(), Ports::default());
        Op { kernel, pass, law: None, fns: None, form, ports, n, first: 0, mat: 0, coef: 0, mem: 0, tap: 0 }
    }

    /// Its name for people: the code of a law, or [`Pass::name`].
    pub fn name(&self) -> &'static str {
        self.law.map_or(self.pass.name(), |law| law.code)
    }

    /// A batch of `n` links of a law, whose functions over `R` are `fns`.
    pub fn links(law: &'static Law, fns: LawFns<R>, form: Form, n: usize) -> Op<R> {
        Op { law: Some(law), fns: Some(fns), form, ..Op::new(Pass::Links, (fns.kernel)(form), n) }
    }
}
