//! The three states of the network between model and scene.
//!
//! Each state holds the one before and dereferences to it, so that nothing can use data before it is known. Links of
//! generators are made with their MATs; `connect` adds the others.
//!
//! ```text
//! lower ─ Resolved ─ connect ─ Wired ─ passes: prune ─ Pruned ─ certify, emit
//!         items, MATs,         links, moving           which MATs stay,
//!         rates, media         points, outputs         what nothing hears
//! ```

use crate::net::families::Families;
use crate::net::waveguides::WaveguideNode;
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

/// Items whose links have a method by `auto`, each with the reason why a pass refuses it; empty if none does.
pub type Chosen = BTreeMap<u32, String>;

/// A parameter driven by a port.
pub struct NetDriven {
    /// Index of the parameter.
    pub param: usize,
    /// Port, an index into [`Resolved::inputs`].
    pub input: u32,
    /// Port values at the smallest and at the largest parameter value \[m\] or \[N\].
    pub span: [f64; 2],
    /// Place of the declaration.
    pub at: Span,
}

/// First state: MATs and the modules of generators, with their numbers in SI.
#[derive(Default)]
pub struct Resolved {
    /// Sound rate \[Hz\].
    pub rate: f64,
    /// Tick \[s\], 1/(rate · oversample).
    pub tick_dt: f64,
    /// Ticks per sample.
    pub oversample: u32,
    /// Sound samples per gesture frame.
    pub ratio: u32,
    /// Behaviour of device ports at the rate boundary.
    pub crossing: Crossing,
    /// Scales between the device and the model.
    pub equivalence: Equivalence,
    /// Low-pass of the sound channels, as in the layout.
    pub lowpass: Vec<f64>,
    /// Items that the modules were made from.
    pub items: Vec<NetItem>,
    /// MATs in document order.
    pub mats: Vec<MatNode>,
    /// LIAs in document order.
    pub lias: Vec<LiaNode>,
    /// Waveguides.
    pub lines: Vec<WaveguideNode>,
    /// Modules by name.
    pub families: Families,
    /// Shared value lists of modules whose numbers are the slots of their item, by length. Most modules share one.
    pub own_values: BTreeMap<usize, Arc<[Source]>>,
    /// Input ports.
    pub inputs: Vec<Input>,
    /// Live parameters.
    pub params: Vec<LiveParam>,
    /// Live parameters driven by ports.
    pub driven: Vec<NetDriven>,
    /// Parameters unused so far, with the places of their declarations.
    pub unused: Vec<(String, Span)>,
    /// A name that exists but is broken, and to which something refers.
    pub incomplete: Option<String>,
    /// Values of the parameters that are not live, for coordinates and gestures.
    pub constants: BTreeMap<String, f64>,
    /// Tables of laws.
    pub tables: Vec<Table>,
    /// Media of the groups; the last is for modules without a group.
    pub media: Vec<Medium>,
    /// items whose method `auto` chose
    pub chosen: Chosen,
    /// Built-in gestures.
    pub gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// presets by name: live parameters and their values
    pub presets: Vec<(String, Vec<(String, f64)>)>,
    /// Duration \[s\], if written.
    pub seconds: Option<f64>,
    /// True for the network of the groups at the gesture rate, whose tick is a frame.
    pub slow: bool,
    /// True if the first two samples follow mi.lib.
    pub as_milib: bool,
    /// Number type that the scene is bound to.
    pub precision: Precision,
    /// Descriptions of what was left out.
    pub left_out: Vec<String>,
}

impl Resolved {
    /// Adds a MAT under its name.
    pub fn add(&mut self, node: MatNode) {
        self.families.insert_mat(&node.name.of, self.mats.len() as u32);
        self.mats.push(node);
    }
}

/// Second state: references are resolved to ends of links, moving points, outputs and force ports.
#[derive(Default)]
pub struct Wired {
    /// First state.
    pub resolved: Resolved,
    /// Moving points.
    pub points: Vec<PointNode>,
    /// Force ports.
    pub pushes: Vec<Push>,
    /// Outputs, then probes.
    pub outs: Vec<OutNode>,
    /// Names of the sound channels.
    pub channels: Vec<String>,
}

/// Third state: which modules stay, because an output or a device depends on them.
#[derive(Default)]
pub struct Pruned {
    /// Second state.
    pub wired: Wired,
    /// True for each MAT that stays, by document number.
    pub alive: Vec<bool>,
    /// MATs that can move and on which no output depends, by document number.
    pub without_output: Vec<u32>,
    /// True for each MAT that hangs on the line port of a quadripole, by document number; empty without quadripoles.
    pub from_lpr: Vec<bool>,
}

/// MATs that an end can act on, as a list without allocation, since many passes need it for every link.
#[derive(Clone, Copy)]
pub enum EndMats<'a> {
    One([u32; 1]),
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
    /// Returns the values of a module whose `n` numbers are the slots of its item.
    pub fn own_values(&mut self, n: usize) -> Arc<[Source]> {
        self.own_values.entry(n).or_insert_with(|| (0..n as u32).map(Source::Slot).collect()).clone()
    }

    /// Returns the parameter values of a module in SI.
    pub fn values(&self, item: u32, values: &[Source]) -> Vec<Option<f64>> {
        let slots = &self.items[item as usize].slots;
        values.iter().map(|s| s.get(slots)).collect()
    }

    /// Returns whether parameters of the item may change while playing.
    pub fn is_live(&self, item: u32) -> bool {
        !self.items[item as usize].follows.is_empty()
    }

    /// Returns the medium of a MAT.
    pub fn medium(&self, m: &MatNode) -> Medium {
        self.medium_of(m.group)
    }

    /// Returns whether this is an external force on a mass on a line, on the sound side. Groups at the gesture rate
    /// have their external forces before any pass.
    pub fn pushes_line(&self, p: &Push) -> bool {
        let in_space = |m: u32| self.mats[m as usize].in_space();
        !self.slow && !matches!(p.end, End::Mat(m) if in_space(m))
    }

    /// Returns the medium of a group; without a group, the medium of the model.
    pub fn medium_of(&self, group: Option<u32>) -> Medium {
        group.and_then(|g| self.media.get(g as usize)).or(self.media.last()).copied().unwrap_or_default()
    }

    /// Returns the tick of a group \[s\]: a sound tick or a gesture frame.
    pub fn tick_of(&self, group: Option<u32>) -> f64 {
        if self.medium_of(group).slow { self.frame_dt() } else { self.tick_dt }
    }

    /// Name of its clock, for findings.
    pub fn clock(&self) -> &'static str {
        if self.slow { "gesture" } else { "sound" }
    }

    /// Returns the duration of a gesture frame \[s\].
    pub fn frame_dt(&self) -> f64 {
        f64::from(self.ratio) / self.rate
    }

    /// Returns the scheme of the linear part of a group.
    pub fn scheme(&self, group: Option<u32>) -> Scheme {
        let medium = self.medium_of(group);
        Scheme::of(medium.method, medium.theta)
    }

    /// Returns whether the model uses PEFRL.
    pub fn is_composed(&self) -> bool {
        self.media.last().is_some_and(|m| m.method == Method::Pefrl)
    }

    /// Returns the limit of the explicit scheme over the limit of the method, by which the certificate scales
    /// stiffness.
    pub fn limit_ratio(&self) -> f64 {
        if self.is_composed() { 4.0 / LIMIT } else { 1.0 }
    }
}

impl Wired {
    /// Returns the rest position of an end.
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

    /// Returns the vector from the first to the second end at rest.
    pub fn rest_vector(&self, [a, b]: [End; 2]) -> [f64; 3] {
        let (a, b) = (self.rest(a), self.rest(b));
        core::array::from_fn(|k| b[k] - a[k])
    }

    /// Returns the number of axes along which an end moves; a moving point is on a line.
    pub fn axes(&self, end: End) -> u8 {
        match end {
            End::Mat(m) => self.mats[m as usize].axes,
            End::Point(_) => 1,
        }
    }

    /// Returns the MATs that an end can act on.
    pub fn under(&self, end: End) -> EndMats<'_> {
        match end {
            End::Mat(m) => EndMats::One([m]),
            End::Point(p) => EndMats::Along(self.families.of(&self.points[p as usize].family).nodes),
        }
    }

    /// Returns the number of nodes that an end can be at.
    pub fn spots(&self, end: End) -> usize {
        let shaped = matches!(end, End::Point(p) if self.points[p as usize].shape.is_some());
        if shaped { 1 } else { self.under(end).len() }
    }

    /// Returns the largest share of a motion under an end that reaches it: 1 for a MAT and for a moving point, and the
    /// sum of the shares for a mass given by modes.
    pub fn reach(&self, end: End) -> f64 {
        let End::Point(p) = end else { return 1.0 };
        self.points[p as usize].shape.as_ref().map_or(1.0, |s| s.0.iter().map(|w| w.abs()).sum())
    }

    /// Returns the name of an end, for reports.
    pub fn end_name(&self, end: End) -> String {
        match end {
            End::Mat(m) => self.mats[m as usize].name.to_string(),
            End::Point(p) => self.points[p as usize].name.clone(),
        }
    }
}
