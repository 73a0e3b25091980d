//! Batches: which links one pass computes: links of one law, and rows of them as runs without indices.

use crate::emit::bands::{self, Mesh};
use crate::emit::plan::Plan;
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::op::{Band, Integrate, Law, MeasureKind};
use ca_core::phi::{implicit, res};

/// Rows shorter than this are gathered: a run has three loops to set up, and waits for what it has just written. Measured
/// for RES: 4 links 15 ns as a run and 8 gathered, 7 links 16 and 12, 11 links 18 and 22.
const SHORTEST_RUN: usize = 10;

/// Rows further apart are not joined. A joint costs as much as a link, some 0.4 ns; of a mesh of 20 x 20, 19 passes less
/// saved 320 ns.
const LONGEST_GAP: usize = 8;

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
    /// what the pass integrates too
    pub integrate: Integrate,
    /// true where the row stands in the order of [`Fold`](ca_core::state::Fold)
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

    /// How many masses a row has.
    pub fn masses(&self) -> usize {
        self.mesh.map_or(self.links.len() + 1, |mesh| mesh.slots as usize)
    }

    /// The first slot of its masses, for a row.
    pub fn slot(&self, plan: &Plan) -> u32 {
        self.mesh.map_or_else(|| plan.ends(self.links[0])[0], |m| m.first)
    }
}

/// What links of one batch have in common.
#[derive(Clone, Copy, PartialEq)]
pub struct Shape {
    law: *const Law,
    /// how it measures
    pub measure: MeasureKind,
    /// how its second port does
    pub onto: Option<MeasureKind>,
    /// for sets, which: each is a batch of its own
    set: Option<u32>,
}

impl Plan<'_> {
    /// Batches of links: in document order, or by law with rows as runs; those behind that are solved after others.
    pub fn batches(&self, class: KernelClass) -> Vec<Batch> {
        let laws = self.laws(class);
        let batch = |(links, stride): (Vec<u32>, usize)| {
            let law = laws[links[0] as usize];
            Batch { links, law, stride, integrate: Integrate::No, folded: false, mesh: None, band: Band::None }
        };
        let mut all: Vec<Batch> = self.grouped(class, &laws).into_iter().map(batch).collect();
        all.sort_by_key(|b| b.law.is_staged());
        all
    }

    /// Links of one batch, with its stride, 0 where there is none.
    fn grouped(&self, class: KernelClass, laws: &[&'static Law]) -> Vec<(Vec<u32>, usize)> {
        let shape = |l: u32| self.shape(l, laws[l as usize]);
        let same = |a: u32, b: u32| shape(a) == shape(b);
        let all: Vec<u32> = (0..self.net.lias.len() as u32).collect();
        if class == KernelClass::Reference {
            return all.chunk_by(|a, b| same(*a, *b)).map(|c| (c.to_vec(), 0)).collect();
        }
        let mut by_law: Vec<Vec<u32>> = Vec::new();
        for l in all {
            match by_law.iter_mut().find(|g| same(g[0], l)) {
                Some(g) => g.push(l),
                None => by_law.push(alloc::vec![l]),
            }
        }
        let mut out = Vec::new();
        for group in by_law {
            let at = shape(group[0]);
            if at.measure != MeasureKind::Line || at.onto.is_some() || laws[group[0] as usize].is_staged() {
                out.push((group, 0));
                continue;
            }
            let mut loose = Vec::new();
            for row in group.chunk_by(|a, b| self.follows(*a, *b)) {
                if let Some(stride) = self.stride(row) {
                    out.push((row.to_vec(), stride));
                } else {
                    loose.extend_from_slice(row);
                }
            }
            if !loose.is_empty() {
                out.push((loose, 0));
            }
        }
        out
    }

    /// Rows joined to longer ones where the next begins soon behind the one before: a pass for each row of a mesh waits
    /// more than it computes. What integrates comes first, in the order of its slots; other rows only where one follows
    /// the other in the list, so that every mass is given its forces in the same order.
    pub fn joined(&self, options: &Options, batches: Vec<Batch>) -> Vec<Batch> {
        if options.kernel != KernelClass::Fast || options.energy {
            return batches;
        }
        let (mut rows, others): (Vec<Batch>, Vec<Batch>) =
            batches.into_iter().partition(|b| b.integrate != Integrate::No);
        let mut meshes: Vec<Mesh> = Vec::new();
        rows.iter().filter_map(|b| b.mesh).for_each(|m| {
            if !meshes.contains(&m) {
                meshes.push(m);
            }
        });
        for mesh in meshes {
            let (of, more): (Vec<Batch>, Vec<Batch>) = rows.into_iter().partition(|b| b.mesh == Some(mesh));
            rows = more;
            rows.extend(bands::joined(self, mesh, &of));
        }
        // links across a mesh stay behind those along
        rows.sort_by_key(|b| b.slot(self));
        let mut all: Vec<Batch> = Vec::with_capacity(rows.len() + others.len());
        for b in rows.into_iter().chain(others) {
            // links that would stand between the two
            let between = |a: &Batch| {
                if a.mesh.is_some() || b.mesh.is_some() {
                    return None;
                }
                let alike = core::ptr::eq(a.law, b.law) && (a.integrate, a.stride) == (b.integrate, b.stride);
                let [last, next] = [a.links[a.links.len() - 1], b.links[0]].map(|l| self.ends(l)[0]);
                let gap = next.checked_sub(last + 1).filter(|_| alike && b.stride > 0 && b.law.wide)? as usize;
                (gap <= if b.integrate == Integrate::No { LONGEST_GAP } else { 1 }).then_some(gap)
            };
            let joints = all.last().and_then(between);
            match (all.last_mut(), joints) {
                (Some(a), Some(joints)) => {
                    a.links.extend(core::iter::repeat_n(JOINT, joints));
                    a.links.extend(b.links);
                }
                _ => all.push(b),
            }
        }
        all
    }

    /// The law each link runs by: its own, but springs in a row with implicit links run by the law of these, θ = 0
    /// and without viscosity, which is the same force. One row of springs costs less than what such links leave of it.
    fn laws(&self, class: KernelClass) -> Vec<&'static Law> {
        let net = self.net;
        let mut laws: Vec<_> = net.lias.iter().map(|l| l.law).collect();
        let ids: Vec<u32> = (0..laws.len() as u32).collect();
        if class == KernelClass::Reference || !laws.iter().any(|l| l.implicit) {
            return laws;
        }
        let spring: &'static Law = &res::LAW;
        let fits = |l: u32| {
            let l = &net.lias[l as usize];
            (l.law.implicit || core::ptr::eq(l.law, spring))
                && l.measure.measure() == MeasureKind::Line
                && l.onto.is_none()
        };
        for row in ids.chunk_by(|a, b| fits(*a) && fits(*b) && self.follows(*a, *b)) {
            if fits(row[0]) && self.stride(row).is_some() && row.iter().any(|l| laws[*l as usize].implicit) {
                for l in row {
                    laws[*l as usize] = &implicit::LAW;
                }
            }
        }
        laws
    }

    /// True where link `b` stands behind `a` in a row.
    fn follows(&self, a: u32, b: u32) -> bool {
        let ([a0, a1], [b0, b1]) = (self.ends(a), self.ends(b));
        a1.wrapping_sub(a0) == b1.wrapping_sub(b0) && b0 == a0.wrapping_add(1)
    }

    /// The stride of a row that is worth a run.
    fn stride(&self, row: &[u32]) -> Option<usize> {
        let [a, b] = self.ends(row[0]);
        let stride = b.wrapping_sub(a);
        (row.len() >= SHORTEST_RUN && stride < u32::MAX / 2).then_some(stride as usize)
    }

    /// What a link that runs by `law` has in common with those of its batch.
    pub fn shape(&self, l: u32, law: &'static Law) -> Shape {
        let node = &self.net.lias[l as usize];
        let set = node.sets.as_ref().map(|_| l);
        Shape { law, measure: node.measure.measure(), onto: node.onto.map(|o| o.measure.measure()), set }
    }
}
