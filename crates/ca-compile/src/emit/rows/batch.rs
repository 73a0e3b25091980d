//! Batch: the links of one pass, as the other files of this folder hand them on: gathered, in a row, or part of a mesh.
//!
//! Decides that what becomes of a batch stands in it (integration, folding, the mesh it is part of), so that each step reads
//! what the one before has decided and none asks another.

use crate::emit::plan::Plan;
use crate::net::Pruned;
use alloc::vec::Vec;
use ca_core::internal::op::{Band, Hub, Integrate, MeasureKind};
use ca_core::{Law, Precision};

/// In place of a link between two rows that run as one: it has no force.
pub const JOINT: u32 = u32::MAX;

/// Links of one pass.
pub struct Batch {
    /// the links, in the order they are computed in, [`JOINT`]s among them; the first is none, but of a mesh
    pub links: Vec<u32>,
    /// the law they run by
    pub law: &'static Law,
    /// of a row, between the slots of two ends; 0 where slots are looked up
    pub stride: usize,
    /// which end of all of them is the same, where the others follow each other
    pub hub: Hub,
    /// what the pass integrates too
    pub integrate: Integrate,
    /// true where the row stands in the order of [`Fold`](ca_core::internal::state::Fold)
    pub folded: bool,
    /// the mesh it is part of, where that runs as one
    pub mesh: Option<Mesh>,
    /// which part
    pub band: Band,
}

impl Batch {
    /// A link of it.
    pub fn some(&self) -> u32 {
        self.links.iter().copied().find(|l| *l != JOINT).unwrap_or(self.links[0])
    }

    /// True for links on a line, of no later turn, that go by no row.
    pub fn is_looked_up(&self, plan: &Plan) -> bool {
        let in_a_row = self.stride > 0 || self.hub != Hub::None || self.folded || self.mesh.is_some();
        if in_a_row || !self.law.stage.is_explicit() || self.links.contains(&JOINT) {
            return false;
        }
        let shape = plan.shape(self.links[0], self.law);
        shape.measure == MeasureKind::Line && shape.onto.is_none()
    }

    /// How many masses a row has.
    pub fn masses(&self) -> usize {
        self.mesh.map_or(self.links.len() + 1, |mesh| mesh.slots as usize)
    }

    /// The first slot of its masses, for a row.
    pub fn slot(&self, plan: &Plan) -> u32 {
        self.mesh.map_or_else(|| plan.ends(self.links[0])[0], |m| m.first)
    }
}

/// Where a mesh stands: its slots in the order of its rows. A first and a last row may lack nodes at their ends, as where the
/// border is held and its corners are joined to nothing.
#[derive(Clone, Copy, PartialEq)]
pub struct Mesh {
    /// its first slot
    pub first: u32,
    /// its slots
    pub slots: u32,
    /// nodes from one row to the next
    pub width: u32,
    /// slots of a first row that lacks nodes, and how many it lacks before them
    pub head: [u32; 2],
    /// the same of a last row
    pub tail: [u32; 2],
}

impl Mesh {
    /// Which node slot `i` is, counted from the first of a first row that lacks none.
    pub fn node(&self, i: usize) -> usize {
        let [slots, head, tail] = [self.slots, self.head[0], self.tail[0]].map(|n| n as usize);
        let [before, behind] = [self.head[1], self.tail[1]].map(|n| n as usize);
        let body = if head > 0 { self.width as usize } else { 0 };
        match i {
            i if i < head => before + i,
            i if i < slots - tail => body + i - head,
            i => body + i - head + behind,
        }
    }

    /// Nodes, those that are lacking before the last among them.
    pub fn nodes(&self) -> usize {
        self.node(self.slots as usize - 1) + 1
    }
}

/// True where the tick is over the number that folded rows are made for.
pub fn can_fold(net: &Pruned) -> bool {
    net.precision == Precision::Double
}
