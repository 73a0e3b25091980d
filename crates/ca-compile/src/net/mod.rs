//! The network between model and scene: its records, and its [states](stage).

pub mod disjoint;
pub mod elongation;
pub mod families;
#[cfg(feature = "analysis")]
pub mod linear;
pub mod linearisation;
mod stage;
pub mod waveguides;
pub mod worst;

pub use families::Family;
pub use stage::{Chosen, NetDriven, Pruned, Resolved, Wired};

use alloc::boxed::Box;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::internal::io::Hear;
use ca_core::internal::kind::builder::Arg;
use ca_core::internal::kind::{MatSpec, PortRole};
use ca_core::internal::live::Source;
use ca_core::internal::op::layout::MeasureKind;
use ca_core::internal::tuning::Method;
use ca_core::{Kind, Law, Name};

/// An item of the model, resolved.
#[derive(Clone)]
pub struct NetItem {
    /// Full name.
    pub name: Arc<str>,
    /// Kind.
    pub kind: &'static Kind,
    /// Index in [`ca_model::Model::items`].
    pub model: usize,
    /// Group, an index into [`Resolved::media`].
    pub group: Option<u32>,
    /// Number of axes along which its MATs move.
    pub dim: u8,
    /// Parameters in SI.
    pub args: Vec<Arg>,
    /// Arguments that follow a live parameter: (argument, parameter, factor).
    pub follows: Vec<(usize, usize, f64)>,
    /// Numbers that its modules refer to.
    pub slots: Vec<Option<f64>>,
}

/// Role of a MAT.
#[derive(Clone, Copy)]
pub enum MatRole {
    /// A mass moved by forces, or a fixed point.
    Mat(&'static MatSpec),
    /// A port moved from outside: per axis its index in [`Resolved::inputs`]. An axis without an input is fixed.
    Port(PortRole, [Option<u32>; 3]),
    /// A mass of a group at the gesture rate, as seen from the sound side: moved by its group.
    Slow,
}

/// A MAT.
#[derive(Clone)]
pub struct MatNode {
    /// Full name.
    pub name: Name,
    /// Code of its kind.
    pub code: &'static str,
    /// Role.
    pub role: MatRole,
    /// Sources of its parameters.
    pub values: Arc<[Source]>,
    /// Number of axes: 1 on a line, 2 in a plane (space with z frozen), 3 in space.
    pub axes: u8,
    /// Rest position \[m\]; on a line only the first number is used.
    pub rest: [f64; 3],
    /// Initial displacement \[m\].
    pub dx0: [f64; 3],
    /// Initial velocity \[m/s\].
    pub v: [f64; 3],
    /// Group, which gives its medium.
    pub group: Option<u32>,
    /// Item it was made from.
    pub item: u32,
}

impl MatNode {
    /// Returns whether no force moves it.
    pub fn is_fixed(&self) -> bool {
        match self.role {
            MatRole::Mat(s) => s.fixed,
            MatRole::Port(..) | MatRole::Slow => true,
        }
    }

    /// Returns whether it is in a plane or in space.
    pub fn in_space(&self) -> bool {
        self.axes > 1
    }

    /// Number of slots in the state: one on a line, three consecutive ones in space.
    pub fn slots(&self) -> u32 {
        if self.in_space() { 3 } else { 1 }
    }
}

/// Measure of a port of a link between its two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// Difference on a line, or along these axes of the first and the second end.
    Line([u8; 2]),
    /// Difference along this unit vector.
    Along([f64; 3]),
    /// Distance in space.
    Radial,
}

impl Measure {
    /// Returns the kind of measure that a kernel uses.
    pub fn measure(self) -> MeasureKind {
        match self {
            Measure::Line(_) => MeasureKind::Line,
            Measure::Along(_) => MeasureKind::Along,
            Measure::Radial => MeasureKind::Radial,
        }
    }
}

/// Second pair of ends, of a quadripole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondPort {
    /// Ends.
    pub ends: [End; 2],
    /// Measure between them.
    pub measure: Measure,
}

/// An end of a link, or the source of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    Mat(u32),
    Point(u32),
}

/// A LIA.
#[derive(Clone)]
pub struct LiaNode {
    /// Full name.
    pub name: Name,
    /// Kind as written.
    pub kind: &'static Kind,
    /// Law that runs.
    pub law: &'static Law,
    /// Sources of its parameters.
    pub values: Arc<[Source]>,
    /// Ends.
    pub ends: [End; 2],
    /// Measure between its ends.
    pub measure: Measure,
    /// Second port, if it is a quadripole.
    pub onto: Option<Box<SecondPort>>,
    /// First and second ends, if it joins all pairs of two sets of MATs in space. Without second ends it joins all
    /// pairs of the first.
    pub sets: Option<Arc<[Vec<u32>; 2]>>,
    /// Rest length \[m\], if written.
    pub l0: Option<f64>,
    /// Softening length \[m\].
    pub soften: f64,
    /// Item it was made from.
    pub item: u32,
}

impl LiaNode {
    /// Returns all its ends.
    pub fn all_ends(&self) -> AllEnds<'_> {
        // `ends` of a set hold one pair only.
        if let Some(sets) = &self.sets {
            let none = End::Mat(u32::MAX);
            return AllEnds { own: [none; 4], at: 0, n: 0, sets: [&sets[0], &sets[1]] };
        }
        let ([a, b], [c, d]) = (self.ends, self.onto.as_ref().map_or(self.ends, |o| o.ends));
        AllEnds { own: [a, b, c, d], at: 0, n: if self.onto.is_some() { 4 } else { 2 }, sets: [&[], &[]] }
    }

    /// Returns whether it measures a distance in space.
    pub fn is_radial(&self) -> bool {
        self.measure == Measure::Radial || self.onto.as_ref().is_some_and(|o| o.measure == Measure::Radial)
    }
}

/// Iterator over the ends of a link, written by hand because many passes use it for every link.
#[derive(Clone)]
pub struct AllEnds<'a> {
    own: [End; 4],
    at: usize,
    n: usize,
    sets: [&'a [u32]; 2],
}

impl Iterator for AllEnds<'_> {
    type Item = End;
    #[inline]
    fn next(&mut self) -> Option<End> {
        if self.at < self.n {
            self.at += 1;
            return Some(self.own[self.at - 1]);
        }
        let set = self.sets.iter_mut().find(|s| !s.is_empty())?;
        let (first, rest) = set.split_first()?;
        *set = rest;
        Some(End::Mat(*first))
    }
}

/// A coordinate of a moving point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinate {
    At(f64),
    Live(u32),
    /// Position of a MAT (an ENX or TGR), in metres taken as a plain number.
    Port(u32),
}

/// A moving point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointNode {
    /// Name as written.
    pub name: String,
    /// Family it moves on.
    pub family: String,
    /// Coordinates: one on a string, two on a mesh.
    pub at: Vec<Coordinate>,
    /// For a mass of a modal group: its share in each mode, and its rest position \[m\].
    pub shape: Option<(Vec<f64>, [f64; 3])>,
}

/// Quantity of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputTap {
    /// Displacement, or the derivative of it that [`OutNode::quantity`] names.
    Position(End),
    /// Sum of the forces on an end.
    ForceOn(End),
    /// Force of a LIA.
    ForceOf(u32),
}

/// An output or a probe.
#[derive(Clone, Debug, PartialEq)]
pub struct OutNode {
    /// Name.
    pub name: String,
    /// Quantity it outputs.
    pub tap: OutputTap,
    /// Quantity derived from a position.
    pub quantity: Hear,
    /// Axis, for an end in space.
    pub axis: u8,
    /// Factor besides the gain: the share of this axis in the direction of the output.
    pub share: f64,
    /// Sound channel; probes come after all channels.
    pub channel: u32,
    /// Source of the gain.
    pub gain: Source,
    /// Item; `None` for probes.
    pub item: Option<u32>,
    /// For a probe, its index in [`crate::Options::probes`].
    pub request: u32,
}

/// Medium of the modules of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Number of axes along which its MATs move: 1, 2 or 3.
    pub dim: u8,
    /// Acceleration of gravity \[m/s²\].
    pub gravity: [f64; 3],
    /// Viscosity of each MAT to ground \[N s/m\].
    pub friction: f64,
    /// Method of linear links and cells.
    pub method: Method,
    /// θ of the method, if written.
    pub theta: Option<f64>,
    /// True if the group is at the gesture rate.
    pub slow: bool,
    /// True if the border is compensated, i.e. forces of links across need not be known as a frame begins.
    pub compensated: bool,
}

impl Default for Medium {
    fn default() -> Medium {
        Medium {
            dim: 1,
            gravity: [0.0; 3],
            friction: 0.0,
            method: Method::Ca,
            theta: None,
            slow: false,
            compensated: false,
        }
    }
}

/// An external force on one axis of an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Index into [`Resolved::inputs`].
    pub input: u32,
    /// End that it acts on.
    pub end: End,
    /// Axis.
    pub axis: u8,
}
