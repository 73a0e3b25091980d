//! Batches: groups links of one law into passes, with rows as runs without indices.

use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::batch::Batch;
use crate::emit::rows::space::{POINT, SHORTEST as SHORTEST_IN_SPACE};
use crate::options::KernelClass;
use alloc::vec::Vec;
use ca_core::Law;
use ca_core::internal::op::{Band, Hub, Integrate, MeasureKind};
use ca_core::internal::phi::{implicit, res};

/// Shortest row that becomes a run; shorter rows are gathered. A run sets up three loops, and waits for values that it
/// has just written. Measured for RES: 4 links 15 ns as a run and 8 gathered, 7 links 16 and 12, 11 links 18 and 22. By
/// the instructions of `cost` it would be 16.
pub const SHORTEST_RUN: usize = 10;

/// Common properties of the links of a batch.
#[derive(Clone, Copy, PartialEq)]
pub struct Shape {
    law: *const Law,
    /// Measure of the first port.
    pub measure: MeasureKind,
    /// Measure of the second port.
    pub onto: Option<MeasureKind>,
    /// Number of a set, which is always a separate batch.
    set: Option<u32>,
}

impl LayoutBuilder<'_> {
    /// Returns the batches of links: in document order, or by law with rows as runs. Batches that are solved after the
    /// others come last. The flag is true if their order differs from arithmetic 2, see [`row_order`](super::row_order).
    pub fn batches(&self, class: KernelClass) -> (Vec<Batch>, bool) {
        let laws = self.laws(class);
        let batch = |(links, stride): (Vec<u32>, usize)| {
            let law = laws[links[0] as usize];
            let (integrate, hub, band) = (Integrate::No, Hub::None, Band::None);
            Batch { links, law, stride, hub, integrate, folded: false, mesh: None, band }
        };
        let (grouped, sorted) = self.grouped(class, &laws);
        let mut all: Vec<Batch> = grouped.into_iter().map(batch).collect();
        all.sort_by_key(|b| !b.law.stage.is_explicit());
        (all, sorted)
    }

    /// Returns the links of each batch with their stride, 0 if there is none, and whether they were sorted.
    fn grouped(&self, class: KernelClass, laws: &[&'static Law]) -> (Vec<(Vec<u32>, usize)>, bool) {
        let shape = |l: u32| self.shape(l, laws[l as usize]);
        let same = |a: u32, b: u32| shape(a) == shape(b);
        let all: Vec<u32> = (0..self.net.lias.len() as u32).collect();
        if class == KernelClass::Reference {
            return (all.chunk_by(|a, b| same(*a, *b)).map(|c| (c.to_vec(), 0)).collect(), false);
        }
        let mut by_law: Vec<Vec<u32>> = Vec::new();
        for l in all {
            match by_law.iter_mut().find(|g| same(g[0], l)) {
                Some(g) => g.push(l),
                None => by_law.push(alloc::vec![l]),
            }
        }
        let plain = |l: u32| {
            let at = shape(l);
            at.onto.is_none() && at.set.is_none() && laws[l as usize].stage.is_explicit()
        };
        let others = |group: &Vec<u32>| {
            let law = laws[group[0] as usize];
            !(law.linear && !law.implicit && plain(group[0]) && shape(group[0]).measure == MeasureKind::Line)
        };
        // Imports keep the bits of the original program.
        let sorts = !self.net.as_milib;
        let mut sorted = sorts && !by_law.is_sorted_by_key(others);
        if sorted {
            by_law.sort_by_key(others);
        }
        let mut out = Vec::new();
        for mut group in by_law {
            let (first, measure) = (group[0], shape(group[0]).measure);
            let now = match measure {
                MeasureKind::Line if sorts && plain(first) => self.sorted(&group, SHORTEST_RUN, 1),
                MeasureKind::Radial if sorts && plain(first) && laws[first as usize].linear => {
                    self.sorted(&group, SHORTEST_IN_SPACE, POINT)
                }
                _ => None,
            };
            sorted |= now.is_some();
            group = now.unwrap_or(group);
            if measure != MeasureKind::Line || !plain(first) {
                out.push((group, 0));
                continue;
            }
            let mut singles = Vec::new();
            for row in group.chunk_by(|a, b| self.follows(*a, *b, 1)) {
                if let Some(stride) = self.stride(row) {
                    out.push((row.to_vec(), stride));
                } else {
                    singles.extend_from_slice(row);
                }
            }
            if !singles.is_empty() {
                out.push((singles, 0));
            }
        }
        (out, sorted)
    }

    /// Returns the law of each link. Springs in a row with implicit links use the implicit law with θ = 0 and without
    /// viscosity, which gives the same force: one row costs less than the parts that implicit links would divide it
    /// into.
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
        for row in ids.chunk_by(|a, b| fits(*a) && fits(*b) && self.follows(*a, *b, 1)) {
            if fits(row[0]) && self.stride(row).is_some() && row.iter().any(|l| laws[*l as usize].implicit) {
                for l in row {
                    laws[*l as usize] = &implicit::LAW;
                }
            }
        }
        laws
    }

    /// Returns whether link `b` follows `a` in a row, with both ends `step` slots further.
    pub fn follows(&self, a: u32, b: u32, step: u32) -> bool {
        let ([a0, a1], [b0, b1]) = (self.ends(a), self.ends(b));
        a1.wrapping_sub(a0) == b1.wrapping_sub(b0) && b0 == a0.wrapping_add(step)
    }

    /// Returns the stride of a row that is long enough for a run.
    fn stride(&self, row: &[u32]) -> Option<usize> {
        let [a, b] = self.ends(row[0]);
        let stride = b.wrapping_sub(a);
        (row.len() >= SHORTEST_RUN && stride < u32::MAX / 2).then_some(stride as usize)
    }

    /// Returns the common properties of a link that runs by `law` and of its batch.
    pub fn shape(&self, l: u32, law: &'static Law) -> Shape {
        let node = &self.net.lias[l as usize];
        let set = node.sets.as_ref().map(|_| l);
        Shape { law, measure: node.measure.measure(), onto: node.onto.as_ref().map(|o| o.measure.measure()), set }
    }
}
