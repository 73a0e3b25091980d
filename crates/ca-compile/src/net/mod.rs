//! The network between model and scene: its records, and the [states](stage) it goes through.

pub mod disjoint;
pub mod elongation;
pub mod families;
#[cfg(feature = "analysis")]
pub mod linear;
pub mod linearisation;
pub mod lines;
mod stage;
pub mod worst;

pub use families::Family;
pub use stage::{NetDriven, Pruned, Resolved, Wired};

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
    /// its full name
    pub name: Arc<str>,
    /// its kind
    pub kind: &'static Kind,
    /// its index in [`ca_model::Model::items`]
    pub model: usize,
    /// its group, an index into [`Resolved::media`]
    pub group: Option<u32>,
    /// axes along which its MATs move
    pub dim: u8,
    /// its parameters in SI
    pub args: Vec<Arg>,
    /// which arguments follow which live parameter: (argument, parameter, factor)
    pub follows: Vec<(usize, usize, f64)>,
    /// the numbers its modules point at
    pub slots: Vec<Option<f64>>,
}

/// What a MAT is.
#[derive(Clone, Copy)]
pub enum MatRole {
    /// moved by forces, or fixed
    Mat(&'static MatSpec),
    /// moved from outside, each axis through its index in [`Resolved::inputs`]; axes without one are fixed
    Port(PortRole, [Option<u32>; 3]),
    /// moved by its group at the gesture rate: what the sound side sees of a mass there
    Slow,
}

/// A MAT.
#[derive(Clone)]
pub struct MatNode {
    /// full name
    pub name: Name,
    /// code of its kind
    pub code: &'static str,
    /// what it is
    pub role: MatRole,
    /// where its parameters come from
    pub values: Arc<[Source]>,
    /// axes it moves along: 1 on a line, 2 in a plane (which is space with z frozen), 3 in space
    pub axes: u8,
    /// rest position \[m\]; on a line only the first number counts
    pub rest: [f64; 3],
    /// initial displacement \[m\]
    pub dx0: [f64; 3],
    /// initial velocity \[m/s\]
    pub v: [f64; 3],
    /// medium
    pub group: Option<u32>,
    /// item it was made from
    pub item: u32,
}

impl MatNode {
    /// True for what no force moves.
    pub fn is_fixed(&self) -> bool {
        match self.role {
            MatRole::Mat(s) => s.fixed,
            MatRole::Port(..) | MatRole::Slow => true,
        }
    }

    /// True in a plane or in space.
    pub fn in_space(&self) -> bool {
        self.axes > 1
    }

    /// Slots it takes in the state: one on a line, three in a row in space.
    pub fn slots(&self) -> u32 {
        if self.in_space() { 3 } else { 1 }
    }
}

/// How a port of a link measures its two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// a difference: on a line, or of these axes of the first and the second end
    Line([u8; 2]),
    /// a difference along this unit vector
    Along([f64; 3]),
    /// the distance in space
    Radial,
}

impl Measure {
    /// The measure a kernel measures by.
    pub fn measure(self) -> MeasureKind {
        match self {
            Measure::Line(_) => MeasureKind::Line,
            Measure::Along(_) => MeasureKind::Along,
            Measure::Radial => MeasureKind::Radial,
        }
    }
}

/// A second pair of ends, for quadripoles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondPort {
    /// its ends
    pub ends: [End; 2],
    /// how it measures
    pub measure: Measure,
}

/// An end of a link, or what an output hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// a MAT
    Mat(u32),
    /// a moving point
    Point(u32),
}

/// A LIA.
#[derive(Clone)]
pub struct LiaNode {
    /// full name
    pub name: Name,
    /// its kind as written
    pub kind: &'static Kind,
    /// the law that runs
    pub law: &'static Law,
    /// where its parameters come from
    pub values: Arc<[Source]>,
    /// its ends
    pub ends: [End; 2],
    /// how it measures them
    pub measure: Measure,
    /// its other ends, if it is a quadripole
    pub onto: Option<Box<SecondPort>>,
    /// the first and the second ends, where it joins every pair of two sets of MATs in space; without second ends,
    /// every pair of the first
    pub sets: Option<Arc<[Vec<u32>; 2]>>,
    /// rest length \[m\] if written
    pub l0: Option<f64>,
    /// softening length \[m\]
    pub soften: f64,
    /// item it was made from
    pub item: u32,
}

impl LiaNode {
    /// All its ends.
    pub fn all_ends(&self) -> AllEnds<'_> {
        // of a set, the ends are those of one pair
        if let Some(sets) = &self.sets {
            let none = End::Mat(u32::MAX);
            return AllEnds { own: [none; 4], at: 0, n: 0, sets: [&sets[0], &sets[1]] };
        }
        let ([a, b], [c, d]) = (self.ends, self.onto.as_ref().map_or(self.ends, |o| o.ends));
        AllEnds { own: [a, b, c, d], at: 0, n: if self.onto.is_some() { 4 } else { 2 }, sets: [&[], &[]] }
    }

    /// True where it measures a distance in space.
    pub fn is_radial(&self) -> bool {
        self.measure == Measure::Radial || self.onto.as_ref().is_some_and(|o| o.measure == Measure::Radial)
    }
}

/// The ends of a link. By hand, since many passes ask for those of every link.
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
    /// for good
    At(f64),
    /// follows a live parameter
    Live(u32),
    /// follows the position of a MAT (an ENX or TGR), in metres read as a plain number
    Port(u32),
}

/// A moving point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointNode {
    /// as written
    pub name: String,
    /// the family it moves on
    pub family: String,
    /// coordinates; one on a string, two on a mesh
    pub at: Vec<Coordinate>,
    /// of a mass in a group that goes by its modes, its share in each of them, and where it rests \[m\]
    pub shape: Option<(Vec<f64>, [f64; 3])>,
}

/// What an output hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputTap {
    /// displacement, or what [`OutNode::hear`] says of it
    Position(End),
    /// summed force
    ForceOn(End),
    /// force of a LIA
    ForceOf(u32),
}

/// An output or a probe.
#[derive(Clone, Debug, PartialEq)]
pub struct OutNode {
    /// its name
    pub name: String,
    /// what it hears
    pub tap: OutputTap,
    /// what of a position
    pub hear: Hear,
    /// of something in space, the axis it hears
    pub axis: u8,
    /// factor, beside the gain: the share of this axis in the direction it hears
    pub share: f64,
    /// sound channel; probes come after all of them
    pub channel: u32,
    /// where the gain comes from
    pub gain: Source,
    /// the item; `None` for probes
    pub item: Option<u32>,
    /// of a probe, its index in [`crate::Options::probes`]
    pub asked: u32,
}

/// What surrounds the modules of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// axes along which its MATs move: 1, 2 or 3
    pub dim: u8,
    /// acceleration of weight \[m/s²\]
    pub gravity: [f64; 3],
    /// viscosity of each MAT to ground \[N s/m\]
    pub friction: f64,
    /// method of linear links and cells
    pub method: Method,
    /// its θ, if written
    pub theta: Option<f64>,
    /// whether it is computed once a gesture frame
    pub slow: bool,
    /// what a frame of the links across does need not be known as it begins
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

/// A force from outside on one axis of an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// index into [`Resolved::inputs`]
    pub input: u32,
    /// what it pushes
    pub end: End,
    /// along which axis
    pub axis: u8,
}
