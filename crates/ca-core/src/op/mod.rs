//! Passes: each [`Op`] is one homogeneous pass over many modules.
//!
//! A compiled layout is a flat list of records. Each holds a plain function that was chosen once, at load, by the law,
//! its form, and whether it has offsets and taps. [`Pass`] and the law identify that function, so that a scene can be
//! bound to another number type. The law of a batch of links holds their kernels, also for laws of another crate (LPR).

use crate::numeric::Real;
use crate::state::State;

pub mod account;
pub mod dc_blocker;
pub mod driven;
pub mod energy;
mod law;
pub mod layout;
pub mod links;
pub mod lowpass;
pub mod output_links;
pub mod pass;
pub mod substep;
pub mod wave;
pub(crate) mod wide;

pub use account::Energies;
pub use law::{Cheaper, Coupled, Law, LawEntry, LawFns, Laws, LoadFns, ParamBinding, SolveStage, Together};
use layout::Layout;
pub use layout::{BorderMethod, MeasureKind, Ports};
pub use links::law::{family, loaded, started};
pub use wide::Vectors;

/// The function of one pass. A tick runs each pass once.
pub type Kernel<R = f64> = fn(&Op<R>, &Layout<R>, &mut State<R>);

/// Masses that a run of links integrates in the same pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Integrate {
    /// no: it only adds forces
    #[default]
    No,
    /// yes: masses with inertia only
    Mas,
    /// yes: masses with their own springs and dampers
    Cel,
}

/// End that all links of a batch share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Hub {
    /// no
    #[default]
    None,
    /// they share the first end
    First,
    /// they share the second end
    Second,
}

/// Treatment of the links across a folded row, which join masses of a mesh a fixed number of slots apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Band {
    /// there are none
    #[default]
    None,
    /// the links across join masses this many slots apart; they are the next batch and run in this pass
    Along(usize),
    /// the batch is the links across, which run in the pass of the batch before
    Across,
}

/// Layout of a batch of links, which determines the kernel.
// independent flags
#[allow(clippy::struct_excessive_bools)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Form {
    /// 0: any MATs; otherwise link i joins `mat + i` and `mat + i + stride`
    pub stride: usize,
    /// links join one MAT to consecutive ones; only for laws in vectors
    pub hub: Hub,
    /// true if some link of the batch has e₀ ≠ 0
    pub offset: bool,
    /// true if the force of each link is stored in [`LinkState::tap`](crate::state::LinkState::tap)
    pub tap: bool,
    /// measure of the first port
    pub measure: MeasureKind,
    /// measure of the second port, for quadripoles
    pub onto: Option<MeasureKind>,
    /// true if some link of a batch that measures distances has a softening length
    pub soften: bool,
    /// true if all pairs of two sets are one module; only for contacts without memory
    pub set: bool,
    /// integration; only for runs of linear laws without memory
    pub integrate: Integrate,
    /// true for the order of [`Fold`](crate::state::Fold); only for runs that integrate, of laws in vectors
    pub folded: bool,
    /// links across the row; only for folded rows
    pub band: Band,
}

/// The task of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Pass {
    /// links, by their law
    Links,
    /// position ports
    Enx,
    /// device ports: how their position enters, and whether late
    DevicesIn(BorderMethod, bool),
    /// ports that run a tick late
    Ahead,
    /// positions of modal masses
    ModalPorts,
    /// parameters driven by ports
    Driven,
    /// positions of moving points
    Points,
    /// energy ledger of the tick before
    Ledger,
    /// ramps of coefficients
    Changes,
    /// cells under moving points
    Aim,
    /// energy ledger after changes
    LedgerOfChanges,
    /// force ports; refused inputs are counted if `counted`
    Enf {
        /// see above
        counted: bool,
    },
    /// weight
    Weight,
    /// arriving waves
    WavesIn,
    /// forces on moving points
    PointsBack,
    /// forces on modal masses, passed on to their modes
    Modes,
    /// implicit links solved as one system
    Implicit,
    /// implicit links that share no mass
    ImplicitPairs,
    /// before links that are solved with the coming motion: represents the free motion of modal masses by a force
    ModesAhead,
    /// contacts solved together
    Contacts {
        /// whether masses of one group are coupled through their modes
        modes: bool,
        /// whether sweeps precede Newton's method: from arithmetic 7 on, if a link is a curve
        sweeps: bool,
    },
    /// after these links: passes their forces on modal masses on to the modes
    ModesAgain,
    /// without force feedback: keeps the forces on devices for the ledger only
    Mute,
    /// forces on device ports
    DevicesOut(BorderMethod),
    /// energy ledger of the border
    LedgerOfBorder(BorderMethod),
    /// stores what the ledger reads in the next tick
    LedgerOfForces,
    /// groups at the gesture rate
    Group {
        /// whether their border is compensated
        compensated: bool,
    },
    /// forces on groups at the gesture rate
    GroupOut {
        /// whether their border is compensated
        compensated: bool,
    },
    /// forces of links in fused passes that outputs read
    OutputLinks,
    /// outputs, one after the other
    Outputs,
    /// outputs summed in lanes
    ManyOutputs,
    /// outputs of one position each
    Positions,
    /// outputs of motion
    Motions,
    /// outputs with a high-pass
    HighPass,
    /// outputs of motion with a high-pass
    HighPassOfMotion,
    /// low-pass of the channels
    LowPass,
    /// past of the low-pass, at a tick between two samples
    Remember,
    /// integration of masses with inertia only
    IntegrateFree,
    /// integration of masses with a spring and a damper to ground
    IntegrateFull,
    /// departing waves
    WavesOut,
    /// clearing of tiny numbers
    Flush,
    /// drift of `pefrl`
    Drift,
    /// kick of `pefrl`
    Kick {
        /// whether cells have springs
        own: bool,
    },
    /// inputs, if a sample has several ticks
    Inputs,
    /// ticks between two samples
    Between,
    /// switches the state to counting ticks
    ToTicks,
    /// switches the state to counting samples
    ToSamples,
}

impl Pass {
    /// Returns the name in the schedule. Passes of links have the name of their law.
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
            Pass::OutputLinks => "heard links",
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

/// A pass, and where its modules are stored.
#[derive(Clone, Copy)]
pub struct Op<R: Real = f64> {
    /// function to run
    pub kernel: Kernel<R>,
    /// which function it is
    pub pass: Pass,
    /// law, for links
    pub law: Option<&'static Law>,
    /// functions of the law over the number type of the tick
    pub fns: Option<LawFns<R>>,
    /// form of a batch of links
    pub form: Form,
    /// ports of the links
    pub ports: Ports,
    /// number of modules, including the padding of a row
    pub n: usize,
    /// first link in [`LinkArrays::ends`](layout::LinkArrays::ends), or first entry of another list that the pass reads
    pub first: usize,
    /// first MAT
    pub mat: usize,
    /// first coefficient in [`State::coef`]; coefficient s of link i is at `coef + s·n + i`
    pub coef: usize,
    /// first number in [`LinkState::mem`](crate::state::LinkState::mem); the memory of link i starts at `mem + i·M`
    pub mem: usize,
    /// first index into [`LinkState::tap`](crate::state::LinkState::tap)
    pub tap: usize,
}

impl<R: Real> Op<R> {
    /// Makes a pass without links that runs the `kernel` of `pass`.
    pub fn new(pass: Pass, kernel: Kernel<R>, n: usize) -> Op<R> {
        let (form, ports) = (Form::default(), Ports::default());
        Op { kernel, pass, law: None, fns: None, form, ports, n, first: 0, mat: 0, coef: 0, mem: 0, tap: 0 }
    }

    /// Returns the name for display: the code of a law, or [`Pass::name`].
    pub fn name(&self) -> &'static str {
        self.law.map_or(self.pass.name(), |law| law.code)
    }

    /// Makes a batch of `n` links of a law, whose functions over `R` are `fns`.
    pub fn links(law: &'static Law, fns: LawFns<R>, form: Form, n: usize) -> Op<R> {
        Op { law: Some(law), fns: Some(fns), form, ..Op::new(Pass::Links, (fns.kernel)(form), n) }
    }
}
