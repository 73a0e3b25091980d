//! Layout: the arrays of a compiled scene that its passes read: counts first, then arrays with their shape.
//!
//! Decides that a pass sees a layout and a state and nothing else: no names, no findings, no list of passes but
//! of those between two samples, so that what the tick depends on is visible in one place. All of it is written
//! once, by the compiler.

mod arrays;
mod driven;
mod group;
mod ledger;
mod modal;
mod outputs;
mod waves;

pub use arrays::{Counts, LinkArrays, OutputArrays, Places, PortArrays, Rates};
pub use driven::Driven;
pub use group::{Copied, Response, SlowGroup};
pub use ledger::{Account, AccountFns, LedgerPlan, Row};
pub use modal::{Modal, ModalCoupling, SolvedModal};
pub use outputs::{DcBlocker, HeardLink, Output, OutputRow, Tap};
pub use waves::{Delay, Junction, Termination, Waves};

use super::{Op, Vectors};
use crate::numeric::ldl::Pattern;
use crate::numeric::{Real, Table};
use alloc::sync::Arc;
use alloc::vec::Vec;

/// How a port of a link measures its two ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum MeasureKind {
    /// the difference of two places: on a line, or along one axis of space
    #[default]
    Line,
    /// the difference of two points in space along a fixed direction
    Along,
    /// the distance of two points in space
    Radial,
}

/// The ports of a batch of links: how they measure, and where their numbers stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Ports {
    /// of the first port
    pub measure: MeasureKind,
    /// its first entry in [`LinkArrays::reach`], unless it is a line
    pub reach: usize,
    /// of the second port, where the links are quadripoles: measure, first entry in [`LinkArrays::onto`], first in
    /// [`LinkArrays::reach`]
    pub onto: Option<(MeasureKind, usize, usize)>,
    /// where all pairs of two sets are one module, its index in [`LinkArrays::pair_sets`]
    pub pair_set: Option<usize>,
}

/// Two sets of points in space of which every pair is joined, or all pairs of one.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct PairSet {
    /// first slot of each member, those of the first set first (members)
    pub members: Vec<u32>,
    /// members that are first ends: the first set
    pub rows: usize,
    /// first member that is a second end; each row joins those from there on that stand behind it
    pub columns: usize,
}

impl PairSet {
    /// The pairs of a first and a second set; without a second, of all pairs of the first.
    pub fn new([first, second]: [&[u32]; 2]) -> PairSet {
        let rows = first.len();
        let columns = if second.is_empty() { 0 } else { rows };
        PairSet { members: [first, second].concat(), rows, columns }
    }

    /// Number of pairs.
    pub fn pairs(&self) -> u64 {
        let (n, rows) = (self.members.len() as u64, self.rows as u64);
        if self.columns == 0 { n * n.saturating_sub(1) / 2 } else { rows * (n - rows) }
    }
}

/// A position port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Enx<R: Real = f64> {
    /// index into [`State::input`](crate::state::State::input)
    pub input: u32,
    /// the MAT it moves
    pub mat: u32,
    /// its rest position \[m\]; the input is absolute
    pub rest: R::Outer,
    /// true where a link at it goes by the motion to come (implicit links, `stable`, `secant`, `newton`): where it is and
    /// how fast at the first tick is then part of the start, see [`crate::Scene::state_from`]
    pub implicit: bool,
}

/// A force port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Enf {
    /// index into [`State::input`](crate::state::State::input)
    pub input: u32,
    /// the MAT it pushes
    pub mat: u32,
}

/// Where a coordinate of a moving point comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum CoordinateSource {
    /// a coefficient, which may be live
    Coef(u32),
    /// the absolute position of a MAT, e.g. an ENX
    Mat(u32),
}

/// A moving point: a MAT without mass that stands between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct MovingPoint {
    /// its own place among the MATs
    pub mat: u32,
    /// first node in [`Places::nodes`]
    pub first: u32,
    /// nodes along the two directions; 1 for a string
    pub size: [u32; 2],
    /// coordinates 0 … 1
    pub at: [CoordinateSource; 2],
}

/// How the position of a device comes in and its force goes out where a frame has several ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Shape {
    /// linear position, trapezoid mean force
    #[default]
    Linear,
    /// position held, mean of the forces around its jump
    Hold,
}

/// How device ports cross the border between the rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossing {
    /// positions in, forces out
    pub shape: Shape,
    /// whole frames between the position of a device and all else
    pub latency: u32,
    /// whether the hand gets a force
    pub feedback: bool,
}

/// The way of device ports across the border: by their [`Shape`], or tick by tick where a frame has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Way {
    /// one tick a frame
    Synchronous,
    /// [`Shape::Linear`]
    Linear,
    /// [`Shape::Hold`]
    Hold,
}

impl Default for Crossing {
    fn default() -> Crossing {
        Crossing { shape: Shape::Linear, latency: 0, feedback: true }
    }
}

/// Links that take part of their force from the time to come: what they join is one matrix of inertia. Those that share
/// no mass with another are pairs, which need none.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct ImplicitLinks<R: Real = f64> {
    /// slots in the state, in the order of elimination (n)
    pub places: Vec<u32>,
    /// pattern of its factor
    pub pattern: Pattern,
    /// first coefficient of the factor; behind it the inertia of the places (n), then the numbers of the pairs
    pub coef: usize,
    /// links whose whole force somebody needs
    pub forces: Vec<LinkForce<R>>,
    /// links that share no mass with another such (any)
    pub pairs: Vec<Pair>,
}

/// An implicit link on a line that is solved by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Pair {
    /// slots in the state of its ends
    pub ends: [u32; 2],
    /// index into [`LinkState::tap`](crate::state::LinkState::tap), where its force is kept
    pub tap: Option<u32>,
}

/// A link by an implicit method whose whole force is needed: it is heard, or what it holds is not moved by forces.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct LinkForce<R: Real = f64> {
    /// indices into [`State::coef`](crate::state::State) of k, z and θ
    pub coef: [u32; 3],
    /// index into [`LinkState::tap`](crate::state::LinkState::tap)
    pub tap: Option<u32>,
    /// entries of its elongation: index into [`ImplicitLinks::places`], and weight
    pub moving: Vec<(u32, R)>,
    /// the same for slots in the state that no force moves
    pub fixed: Vec<(u32, R)>,
}

/// A sample of several ticks.
#[derive(Clone)]
pub struct Substeps<R: Real = f64> {
    /// ticks in a sample, R
    pub times: u32,
    /// the passes of one tick between two samples
    pub tick: Arc<[Op<R>]>,
    /// indices into [`State::input`](crate::state::State::input) that are given once a sample (any)
    pub inputs: Vec<u32>,
}

/// The arrays.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Layout<R: Real = f64> {
    /// how often it runs
    pub rates: Rates<R>,
    /// how much there is
    pub counts: Counts,
    /// what links join
    pub links: LinkArrays<R>,
    /// where MATs are
    pub places: Places<R>,
    /// tables of laws (any)
    pub tables: Vec<Table<R>>,
    /// what comes in, and goes to devices
    pub ports: PortArrays<R>,
    /// waveguides
    pub waves: Waves<R>,
    /// MATs with weight (any)
    pub weighed: Vec<u32>,
    /// what is heard
    pub out: OutputArrays<R>,
    /// what is solved in each tick, where implicit links are solved together
    pub implicit: Option<ImplicitLinks<R>>,
    /// what the ledger needs, where the scene keeps one
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub ledger: Option<LedgerPlan<R>>,
    /// the vectors its passes use; the bits are the same with all
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub vectors: Vectors,
}

impl<R: Real> Layout<R> {
    /// The way of device ports across the border.
    pub fn way(&self) -> Way {
        match (self.rates.frame, self.ports.crossing.shape) {
            (1, _) => Way::Synchronous,
            (_, Shape::Linear) => Way::Linear,
            (_, Shape::Hold) => Way::Hold,
        }
    }

    /// Ticks in a sample: 1, unless the model asks for more.
    pub fn oversample(&self) -> u32 {
        self.rates.substeps.as_ref().map_or(1, |f| f.times)
    }
}
