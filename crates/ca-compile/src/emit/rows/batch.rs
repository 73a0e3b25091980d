//! Batch: the links of one pass, gathered, in a row, or part of a mesh.
//!
//! A batch contains all decisions about it (integration, folding, mesh), so that each step only reads the result of the
//! previous one.

use crate::emit::layout_builder::LayoutBuilder;
use crate::net::Pruned;
use alloc::vec::Vec;
use ca_core::internal::op::{Band, Hub, Integrate, MeasureKind};
use ca_core::{Law, Precision};

/// Placeholder without force for a link between two rows that run as one.
pub const JOINT: u32 = u32::MAX;

/// Links of one pass.
pub struct Batch {
    /// Links in the order of computation, including [`JOINT`]s. The first is a joint only in a mesh.
    pub links: Vec<u32>,
    /// Law of the links.
    pub law: &'static Law,
    /// Distance between the slots of the two ends in a row; 0 if slots are looked up.
    pub stride: usize,
    /// End that all links share, if the other ends are consecutive.
    pub hub: Hub,
    /// Masses that the pass integrates too.
    pub integrate: Integrate,
    /// True if the row is in the order of [`Fold`](ca_core::internal::state::Fold).
    pub folded: bool,
    /// Mesh that it is part of, if that runs as one.
    pub mesh: Option<Mesh>,
    /// Part of the mesh.
    pub band: Band,
}

impl Batch {
    /// Returns one of its links.
    pub fn some(&self) -> u32 {
        self.links.iter().copied().find(|l| *l != JOINT).unwrap_or(self.links[0])
    }

    /// Returns whether it consists of explicit links on a line that are looked up.
    pub fn is_looked_up(&self, builder: &LayoutBuilder) -> bool {
        let in_a_row = self.stride > 0 || self.hub != Hub::None || self.folded || self.mesh.is_some();
        if in_a_row || !self.law.stage.is_explicit() || self.links.contains(&JOINT) {
            return false;
        }
        let shape = builder.shape(self.links[0], self.law);
        shape.measure == MeasureKind::Line && shape.onto.is_none()
    }

    /// Returns the number of masses of a row.
    pub fn masses(&self) -> usize {
        self.mesh.map_or(self.links.len() + 1, |mesh| mesh.slots as usize)
    }

    /// Returns the first slot of the masses of a row.
    pub fn slot(&self, builder: &LayoutBuilder) -> u32 {
        self.mesh.map_or_else(|| builder.ends(self.links[0])[0], |m| m.first)
    }
}

/// Slots of a mesh, in the order of its rows. The first and the last row may lack nodes at their ends, e.g. if the
/// border is fixed and its corners are not linked.
#[derive(Clone, Copy, PartialEq)]
pub struct Mesh {
    /// First slot.
    pub first: u32,
    /// Number of slots.
    pub slots: u32,
    /// Nodes from one row to the next.
    pub width: u32,
    /// Slots of an incomplete first row, and the number of missing nodes before them.
    pub head: [u32; 2],
    /// The same for the last row.
    pub tail: [u32; 2],
}

impl Mesh {
    /// Returns the node of slot `i`, counted from the first node of a complete first row.
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

    /// Returns the number of nodes, including missing ones before the last.
    pub fn nodes(&self) -> usize {
        self.node(self.slots as usize - 1) + 1
    }
}

/// Returns whether the tick has the number type for which folded rows are made.
pub fn can_fold(net: &Pruned) -> bool {
    net.precision == Precision::Double
}
