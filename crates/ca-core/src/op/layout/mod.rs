//! The arrays of a compiled scene that its passes read: counts first, then arrays with their shapes.
//!
//! A pass reads a layout and a state and nothing else, so everything a tick depends on is in one place. It lacks names
//! and findings, and its only list of passes is for ticks between samples. The compiler writes it once.

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
pub use ledger::{Account, AccountFns, LedgerLayout, Row};
pub use modal::{Modal, ModalCoupling, SolvedModal};
pub use outputs::{DcBlocker, Output, OutputLink, OutputRow, Tap};
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
    /// difference of two positions: on a line, or along one axis of space
    #[default]
    Line,
    /// difference of two points in space along a fixed direction
    Along,
    /// distance of two points in space
    Radial,
}

/// Ports of a batch of links: how they measure, and where their data is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Ports {
    /// measure of the first port
    pub measure: MeasureKind,
    /// first entry of the first port in [`LinkArrays::reach`], unless it measures on a line
    pub reach: usize,
    /// second port, for quadripoles: measure, first entry in [`LinkArrays::onto`], first entry in [`LinkArrays::reach`]
    pub onto: Option<(MeasureKind, usize, usize)>,
    /// index in [`LinkArrays::pair_sets`], if all pairs of two sets are one module
    pub pair_set: Option<usize>,
}

/// Two sets of points in space whose pairs are all joined, or one set with all its pairs.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct PairSet {
    /// first slot of each member, the first set first (members)
    pub members: Vec<u32>,
    /// number of members of the first set, which are first ends
    pub rows: usize,
    /// first member that is a second end; each row joins the members from there on that come after it
    pub columns: usize,
}

impl PairSet {
    /// Makes all pairs of a first and a second set, or all pairs within the first if the second is empty.
    pub fn new([first, second]: [&[u32]; 2]) -> PairSet {
        let rows = first.len();
        let columns = if second.is_empty() { 0 } else { rows };
        PairSet { members: [first, second].concat(), rows, columns }
    }

    /// Returns the number of pairs.
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
    /// MAT that it moves
    pub mat: u32,
    /// rest position of the MAT \[m\]; the input is absolute
    pub rest: R::Outer,
    /// true if a link at it is solved with the coming motion (implicit links, `stable`, `secant`, `newton`). Position
    /// and motion of the port at the first tick are then part of the start, see [`crate::Scene::state_from`]
    pub implicit: bool,
}

/// A force port.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Enf {
    /// index into [`State::input`](crate::state::State::input)
    pub input: u32,
    /// MAT that it pushes
    pub mat: u32,
}

/// Source of a coordinate of a moving point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum CoordinateSource {
    /// coefficient, which may be live
    Coef(u32),
    /// absolute position of a MAT, e.g. an ENX
    Mat(u32),
}

/// A moving point: a MAT without mass between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct MovingPoint {
    /// slot of the point
    pub mat: u32,
    /// first node in [`Places::nodes`]
    pub first: u32,
    /// numbers of nodes along the two directions; the second is 1 for a string
    pub size: [u32; 2],
    /// coordinates, from 0 to 1
    pub at: [CoordinateSource; 2],
}

/// Rule by which device ports cross the border if a frame has several ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Shape {
    /// position moves linearly, force is the trapezoid mean
    #[default]
    Linear,
    /// position is held, force is the mean around its jump
    Hold,
}

/// Crossing of the border between the rates by device ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Crossing {
    /// shape of positions and forces
    pub shape: Shape,
    /// whole frames of delay added between the position of a device and the scene
    pub latency: u32,
    /// true if the device gets a force
    pub feedback: bool,
}

/// Rule by which device ports cross the border: their [`Shape`], or tick by tick if a frame has one tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum BorderMethod {
    /// one tick per frame
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

/// Links that take part of their force from the next positions. Linked ones are solved as one matrix of inertia. A pair
/// shares no mass with another such link and needs no matrix.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct ImplicitLinks<R: Real = f64> {
    /// slots in the state, in elimination order (n)
    pub places: Vec<u32>,
    /// pattern of the factor
    pub pattern: Pattern,
    /// first coefficient of the factor, followed by the inertia of the MATs (n), then the numbers of the pairs
    pub coef: usize,
    /// links whose whole force is needed
    pub forces: Vec<LinkForce<R>>,
    /// links that share no mass with another implicit link (any)
    pub pairs: Vec<Pair>,
}

/// An implicit link on a line that is solved by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Pair {
    /// slots of its ends
    pub ends: [u32; 2],
    /// index into [`LinkState::tap`](crate::state::LinkState::tap), if its force is stored
    pub tap: Option<u32>,
}

/// An implicit link whose whole force is needed: an output reads it, or it acts on a MAT that forces do not move.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct LinkForce<R: Real = f64> {
    /// indices into [`State::coef`](crate::state::State) of k, z and θ
    pub coef: [u32; 3],
    /// index into [`LinkState::tap`](crate::state::LinkState::tap)
    pub tap: Option<u32>,
    /// moving ends of its elongation: index into [`ImplicitLinks::places`], and weight
    pub moving: Vec<(u32, R)>,
    /// other ends: slot in the state of a MAT that forces do not move, and weight
    pub fixed: Vec<(u32, R)>,
}

/// A sample that consists of several ticks.
#[derive(Clone)]
pub struct Substeps<R: Real = f64> {
    /// ticks per sample, R
    pub times: u32,
    /// passes of one tick between two samples
    pub tick: Arc<[Op<R>]>,
    /// inputs that are given once per sample: indices into [`State::input`](crate::state::State) (any)
    pub inputs: Vec<u32>,
}

/// The arrays that the passes of a scene read.
#[derive(Clone, Default)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Layout<R: Real = f64> {
    /// rates
    pub rates: Rates<R>,
    /// lengths of the arrays of a state
    pub counts: Counts,
    /// ends of links
    pub links: LinkArrays<R>,
    /// positions of MATs
    pub places: Places<R>,
    /// tables of laws (any)
    pub tables: Vec<Table<R>>,
    /// ports
    pub ports: PortArrays<R>,
    /// waveguides
    pub waves: Waves<R>,
    /// MATs with weight (any)
    pub weighed: Vec<u32>,
    /// outputs
    pub out: OutputArrays<R>,
    /// implicit links, if the scene has any
    pub implicit: Option<ImplicitLinks<R>>,
    /// data of the ledger, if the scene has one
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub ledger: Option<LedgerLayout<R>>,
    /// vectors that its passes use; the bits are the same with all
    #[cfg_attr(feature = "bytes", serde(skip))]
    pub vectors: Vectors,
}

impl<R: Real> Layout<R> {
    /// Returns how device ports cross the border.
    pub fn border_method(&self) -> BorderMethod {
        match (self.rates.frame, self.ports.crossing.shape) {
            (1, _) => BorderMethod::Synchronous,
            (_, Shape::Linear) => BorderMethod::Linear,
            (_, Shape::Hold) => BorderMethod::Hold,
        }
    }

    /// Returns the ticks per sample: 1 unless the model sets `oversample`.
    pub fn oversample(&self) -> u32 {
        self.rates.substeps.as_ref().map_or(1, |f| f.times)
    }
}
