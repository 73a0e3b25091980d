//! Net: the network between model and scene: every module by itself, references resolved, numbers in SI.

#[cfg(feature = "analysis")]
pub mod linear;
pub mod linearisation;
pub mod lines;
pub mod worst;

use crate::net::lines::LineNode;
use alloc::collections::BTreeMap;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::equivalence::Equivalence;
use ca_core::kind::Kind;
use ca_core::kind::MatSpec;
use ca_core::kind::PortRole;
use ca_core::layout::Crossing;
use ca_core::layout::Gauge;
use ca_core::live::{LiveParam, Source};
use ca_core::op::law::Law;
use ca_core::scene::Input;
use ca_core::sketch::Arg;
use ca_core::table::Table;
use ca_core::tuning::Scheme;
use ca_model::Span;

/// An item of the model, resolved.
#[derive(Clone)]
pub struct NetItem {
    /// its full name
    pub name: String,
    /// its kind
    pub kind: &'static Kind,
    /// its place in [`ca_model::Model::items`]
    pub model: usize,
    /// its group, a place in [`Net::media`]
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
    /// moved from outside, each axis through its place in [`Net::inputs`]; axes without one are fixed
    Port(PortRole, [Option<u32>; 3]),
}

/// A MAT.
#[derive(Clone)]
pub struct MatNode {
    /// full name
    pub name: String,
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
            MatRole::Port(..) => true,
        }
    }

    /// True in a plane or in space.
    pub fn in_space(&self) -> bool {
        self.axes > 1
    }

    /// Places it takes in the state: one on a line, three in a row in space.
    pub fn places(&self) -> u32 {
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
    /// The gauge a kernel measures by.
    pub fn gauge(self) -> Gauge {
        match self {
            Measure::Line(_) => Gauge::Line,
            Measure::Along(_) => Gauge::Along,
            Measure::Radial => Gauge::Radial,
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
    pub name: String,
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
    pub onto: Option<SecondPort>,
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
    pub fn all_ends(&self) -> impl Iterator<Item = End> + '_ {
        let sets = self.sets.iter().flat_map(|s| s.iter().flatten().map(|m| End::Mat(*m)));
        // of a set, the ends are those of one pair
        let own = self.ends.into_iter().chain(self.onto.into_iter().flat_map(|o| o.ends));
        own.take(if self.sets.is_some() { 0 } else { 4 }).chain(sets)
    }

    /// True where it measures a distance in space.
    pub fn is_radial(&self) -> bool {
        self.measure == Measure::Radial || self.onto.is_some_and(|o| o.measure == Measure::Radial)
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
    /// displacement
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
    /// of a probe, its place in [`crate::Options::probes`]
    pub asked: u32,
}

/// The modules under one name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Family {
    /// MATs that `name[i]` means
    pub masses: Vec<u32>,
    /// LIAs that `name.link[i]` means
    pub links: Vec<u32>,
    /// fixed points that `name.end[i]` means
    pub tips: Vec<u32>,
    /// nodes a moving point may stand between
    pub nodes: Vec<u32>,
    /// their arrangement; `[n, 1]` in a row
    pub size: [u32; 2],
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
    /// method of linear links and cells, a place in [`ca_core::phi::implicit::METHOD`]
    pub method: f64,
    /// its θ, if written
    pub theta: Option<f64>,
}

impl Default for Medium {
    fn default() -> Medium {
        Medium { dim: 1, gravity: [0.0; 3], friction: 0.0, method: 0.0, theta: None }
    }
}

/// A force from outside on one axis of an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// place in [`Net::inputs`]
    pub input: u32,
    /// what it pushes
    pub end: End,
    /// along which axis
    pub axis: u8,
}

/// The network.
#[derive(Default)]
pub struct Net {
    /// sound rate \[Hz\]
    pub rate: f64,
    /// tick \[s\], 1/(rate · oversample)
    pub te: f64,
    /// ticks in a sample
    pub oversample: u32,
    /// sound samples per gesture frame
    pub ratio: u32,
    /// how device ports cross the border
    pub crossing: Crossing,
    /// how large and heavy the model is in the hand
    pub equivalence: Equivalence,
    /// low-pass of the sound channels, as in the layout
    pub lowpass: Vec<f64>,
    /// the items the modules were made from
    pub items: Vec<NetItem>,
    /// MATs in document order
    pub mats: Vec<MatNode>,
    /// LIAs in document order
    pub lias: Vec<LiaNode>,
    /// strings of waves
    pub lines: Vec<LineNode>,
    /// moving points
    pub points: Vec<PointNode>,
    /// names
    pub families: BTreeMap<String, Family>,
    /// ports that take something
    pub inputs: Vec<Input>,
    /// force ports
    pub pushes: Vec<Push>,
    /// outputs, then probes
    pub outs: Vec<OutNode>,
    /// names of the sound channels
    pub channels: Vec<String>,
    /// live parameters
    pub params: Vec<LiveParam>,
    /// parameters that nothing has used so far, and where they are declared
    pub unused: Vec<(String, Span)>,
    /// a name that is there but broken, to which something refers
    pub incomplete: Option<String>,
    /// values of the parameters that are not live, for coordinates and gestures
    pub constants: BTreeMap<String, f64>,
    /// tables
    pub tables: Vec<Table>,
    /// media of the groups; the last is that of modules without group
    pub media: Vec<Medium>,
    /// built-in gestures
    pub gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// how long it sounds \[s\], if said
    pub seconds: Option<f64>,
    /// whether the first two samples are those of mi.lib
    pub as_milib: bool,
    /// what was left out, in words
    pub left_out: Vec<String>,
    /// MATs that stay, by document number
    pub alive: Vec<bool>,
    /// MATs that could move and that nothing hears, by document number
    pub unheard: Vec<u32>,
    /// MATs that hang on the line port of a quadripole, by document number; empty where there is none
    pub fed: Vec<bool>,
}

impl Net {
    /// Parameter values of a module, in SI.
    pub fn values(&self, item: u32, values: &[Source]) -> Vec<Option<f64>> {
        let slots = &self.items[item as usize].slots;
        values.iter().map(|s| s.get(slots)).collect()
    }

    /// True where the module's parameters may change while playing.
    pub fn is_live(&self, item: u32) -> bool {
        !self.items[item as usize].follows.is_empty()
    }

    /// The medium of a MAT.
    pub fn medium(&self, m: &MatNode) -> Medium {
        self.medium_of(m.group)
    }

    /// The medium of a group; that of the model without one.
    pub fn medium_of(&self, group: Option<u32>) -> Medium {
        group.and_then(|g| self.media.get(g as usize)).or(self.media.last()).copied().unwrap_or_default()
    }

    /// How what is linear in a group is computed.
    pub fn scheme(&self, group: Option<u32>) -> Scheme {
        let medium = self.medium_of(group);
        Scheme::of(medium.method, medium.theta)
    }

    /// Rest position of an end.
    pub fn rest(&self, end: End) -> [f64; 3] {
        match end {
            End::Mat(m) => self.mats[m as usize].rest,
            End::Point(p) => {
                let point = &self.points[p as usize];
                let first = || self.families[&point.family].nodes.first().copied();
                let rest = point.shape.as_ref().map(|s| s.1);
                rest.or_else(|| first().map(|m| self.mats[m as usize].rest)).unwrap_or_default()
            }
        }
    }

    /// The vector from the first to the second end, at rest.
    pub fn apart(&self, [a, b]: [End; 2]) -> [f64; 3] {
        let (a, b) = (self.rest(a), self.rest(b));
        core::array::from_fn(|k| b[k] - a[k])
    }

    /// Axes along which an end moves; moving points are on a line.
    pub fn axes(&self, end: End) -> u8 {
        match end {
            End::Mat(m) => self.mats[m as usize].axes,
            End::Point(_) => 1,
        }
    }

    /// The MATs an end can act on.
    pub fn under(&self, end: End) -> Vec<u32> {
        match end {
            End::Mat(m) => alloc::vec![m],
            End::Point(p) => self.families[&self.points[p as usize].family].nodes.clone(),
        }
    }

    /// How many places an end may stand at.
    pub fn spots(&self, end: End) -> usize {
        let shaped = matches!(end, End::Point(p) if self.points[p as usize].shape.is_some());
        if shaped { 1 } else { self.under(end).len() }
    }

    /// How much of a motion under an end reaches it at the most: 1 of what it is or moves along, the sum of its shares of a
    /// mass in modes.
    pub fn reach(&self, end: End) -> f64 {
        let End::Point(p) = end else { return 1.0 };
        self.points[p as usize].shape.as_ref().map_or(1.0, |s| s.0.iter().map(|w| w.abs()).sum())
    }

    /// Name of an end, for reports.
    pub fn end_name(&self, end: End) -> &str {
        match end {
            End::Mat(m) => &self.mats[m as usize].name,
            End::Point(p) => &self.points[p as usize].name,
        }
    }
}
