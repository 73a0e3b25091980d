//! The network between model and scene, in the three states it goes through. What a state adds is not there before it:
//! each state holds the one before and reads as it. Links of generators are made with their MATs; `connect` adds the others.
//!
//! ```text
//! lower ─ Resolved ─ connect ─ Wired ─ passes: prune ─ Pruned ─ certify, emit
//!         items, MATs,         links, moving           which MATs stay,
//!         rates, media         points, outputs         what nothing hears
//! ```

use crate::net::families::Families;
use crate::net::lines::LineNode;
use crate::net::{End, LiaNode, MatNode, Medium, NetItem, OutNode, PointNode, Push};
use alloc::collections::BTreeMap;
use alloc::string::{String, ToString};
use alloc::sync::Arc;
use alloc::vec::Vec;
use ca_core::equivalence::Equivalence;
use ca_core::internal::live::Source;
use ca_core::internal::method::pefrl::LIMIT;
use ca_core::internal::op::layout::Crossing;
use ca_core::internal::tuning::{Method, Scheme};
use ca_core::{Input, LiveParam, Precision, Table};
use ca_model::Span;
use core::ops::{Deref, DerefMut};

/// A parameter that a port drives.
pub struct NetDriven {
    /// its number
    pub param: usize,
    /// the port: a place in [`Resolved::inputs`]
    pub input: u32,
    /// where the port is at the smallest and at the largest value \[m\] or \[N\]
    pub span: [f64; 2],
    /// where it is declared
    pub at: Span,
}

/// Every module by itself, its numbers in SI: MATs, and what generators made.
#[derive(Default)]
pub struct Resolved {
    /// sound rate \[Hz\]
    pub rate: f64,
    /// tick \[s\], 1/(rate · oversample)
    pub tick_dt: f64,
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
    /// names
    pub families: Families,
    /// the values of a module whose numbers are those of its item, by how many there are: most share them
    pub own_values: BTreeMap<usize, Arc<[Source]>>,
    /// ports that take something
    pub inputs: Vec<Input>,
    /// live parameters
    pub params: Vec<LiveParam>,
    /// those of them that ports drive
    pub driven: Vec<NetDriven>,
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
    /// whether this is the network of groups at the gesture rate, whose ticks are frames
    pub slow: bool,
    /// whether the first two samples are those of mi.lib
    pub as_milib: bool,
    /// the number that the scene is bound to
    pub precision: Precision,
    /// what was left out, in words
    pub left_out: Vec<String>,
}

impl Resolved {
    /// Adds a MAT, under its name.
    pub fn add(&mut self, node: MatNode) {
        self.families.insert_mat(&node.name.of, self.mats.len() as u32);
        self.mats.push(node);
    }
}

/// What modules refer to is found: links between ends, moving points, what is heard and pushed.
#[derive(Default)]
pub struct Wired {
    /// the modules
    pub resolved: Resolved,
    /// moving points
    pub points: Vec<PointNode>,
    /// force ports
    pub pushes: Vec<Push>,
    /// outputs, then probes
    pub outs: Vec<OutNode>,
    /// names of the sound channels
    pub channels: Vec<String>,
}

/// Which modules stay, since an output or a hand hears them.
#[derive(Default)]
pub struct Pruned {
    /// the modules, connected
    pub wired: Wired,
    /// MATs that stay, by document number
    pub alive: Vec<bool>,
    /// MATs that could move and that nothing hears, by document number
    pub unheard: Vec<u32>,
    /// MATs that hang on the line port of a quadripole, by document number; empty where there is none
    pub from_lpr: Vec<bool>,
}

/// The MATs an end can act on, as a list: that of every link is asked for in many passes, so that none is made.
#[derive(Clone, Copy)]
pub enum EndMats<'a> {
    /// a MAT
    One([u32; 1]),
    /// what a moving point moves along
    Along(&'a [u32]),
}

impl Deref for EndMats<'_> {
    type Target = [u32];
    fn deref(&self) -> &[u32] {
        match self {
            EndMats::One(m) => m,
            EndMats::Along(all) => all,
        }
    }
}

impl<'a> IntoIterator for EndMats<'a> {
    type Item = u32;
    type IntoIter = core::iter::Chain<core::option::IntoIter<u32>, core::iter::Copied<core::slice::Iter<'a, u32>>>;
    fn into_iter(self) -> Self::IntoIter {
        let (one, all) = match self {
            EndMats::One([m]) => (Some(m), &[][..]),
            EndMats::Along(all) => (None, all),
        };
        one.into_iter().chain(all.iter().copied())
    }
}

impl From<Resolved> for Wired {
    fn from(resolved: Resolved) -> Wired {
        Wired { resolved, ..Wired::default() }
    }
}

/// Each state reads as the one before.
macro_rules! reads_as {
    ($state:ty: $before:ty, $field:ident) => {
        impl Deref for $state {
            type Target = $before;
            fn deref(&self) -> &$before {
                &self.$field
            }
        }
        impl DerefMut for $state {
            fn deref_mut(&mut self) -> &mut $before {
                &mut self.$field
            }
        }
    };
}

reads_as!(Wired: Resolved, resolved);
reads_as!(Pruned: Wired, wired);

impl Resolved {
    /// The values of a module whose `n` numbers are those of its item.
    pub fn own_values(&mut self, n: usize) -> Arc<[Source]> {
        self.own_values.entry(n).or_insert_with(|| (0..n as u32).map(Source::Slot).collect()).clone()
    }

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

    /// True for a force from outside on a mass that is on a line, in the sound. (What pushes masses of groups at the gesture rate is there
    /// before any pass.)
    pub fn pushes_line(&self, p: &Push) -> bool {
        let in_space = |m: u32| self.mats[m as usize].in_space();
        !self.slow && !matches!(p.end, End::Mat(m) if in_space(m))
    }

    /// The medium of a group; that of the model without one.
    pub fn medium_of(&self, group: Option<u32>) -> Medium {
        group.and_then(|g| self.media.get(g as usize)).or(self.media.last()).copied().unwrap_or_default()
    }

    /// The tick of a group \[s\]: that of the sound, or a gesture frame.
    pub fn tick_of(&self, group: Option<u32>) -> f64 {
        if self.medium_of(group).slow { self.frame_dt() } else { self.tick_dt }
    }

    /// What its ticks are of, for people.
    pub fn clock(&self) -> &'static str {
        if self.slow { "gesture" } else { "sound" }
    }

    /// A gesture frame \[s\].
    pub fn frame_dt(&self) -> f64 {
        f64::from(self.ratio) / self.rate
    }

    /// How what is linear in a group is computed.
    pub fn scheme(&self, group: Option<u32>) -> Scheme {
        let medium = self.medium_of(group);
        Scheme::of(medium.method, medium.theta)
    }

    /// True where the model goes by PEFRL.
    pub fn is_composed(&self) -> bool {
        self.media.last().is_some_and(|m| m.method == Method::Pefrl)
    }

    /// The limit of the explicit scheme as a share of that of the method: what the certificate counts stiffness by.
    pub fn limit_ratio(&self) -> f64 {
        if self.is_composed() { 4.0 / LIMIT } else { 1.0 }
    }
}

impl Wired {
    /// Rest position of an end.
    pub fn rest(&self, end: End) -> [f64; 3] {
        match end {
            End::Mat(m) => self.mats[m as usize].rest,
            End::Point(p) => {
                let point = &self.points[p as usize];
                let first = || self.families.of(&point.family).nodes.first().copied();
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
    pub fn under(&self, end: End) -> EndMats<'_> {
        match end {
            End::Mat(m) => EndMats::One([m]),
            End::Point(p) => EndMats::Along(self.families.of(&self.points[p as usize].family).nodes),
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
    pub fn end_name(&self, end: End) -> String {
        match end {
            End::Mat(m) => self.mats[m as usize].name.to_string(),
            End::Point(p) => self.points[p as usize].name.clone(),
        }
    }
}
