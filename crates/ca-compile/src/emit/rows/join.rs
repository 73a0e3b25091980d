//! Join: rows that run as one, with joints without force between them.
//!
//! This step follows the decision on integration: two rows are joined only if they integrate alike, and if the order of
//! forces on each mass is kept.

use crate::emit::cost;
use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::bands;
use crate::emit::rows::batch::{Batch, JOINT, Mesh};
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::internal::op::Integrate;

impl LayoutBuilder<'_> {
    /// Joins rows to longer ones if the next begins soon after the previous: a pass per row of a mesh would wait longer
    /// than it computes. Rows that integrate come first, in the order of their slots. Other rows are joined only if
    /// they are adjacent in the list, so that the order of forces on each mass is kept.
    pub fn joined(&self, options: &Options, batches: Vec<Batch>) -> Vec<Batch> {
        if options.kernel != KernelClass::Fast {
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
        // The stable sort keeps links across a mesh after those along it.
        rows.sort_by_key(|b| b.slot(self));
        // Joints at masses that a row integrates would be links of another row at them.
        let taken: Vec<[u32; 2]> = rows.iter().map(|b| [b.slot(self), b.slot(self) + b.masses() as u32]).collect();
        let is_free = |from: u32, to: u32| {
            let next = taken.partition_point(|t| t[1] <= from);
            taken.get(next).is_none_or(|t| to <= t[0])
        };
        let mut all: Vec<Batch> = Vec::with_capacity(rows.len() + others.len());
        for b in rows.into_iter().chain(others) {
            // Number of joints between the two rows, if they can be joined.
            let between = |a: &Batch| {
                if a.mesh.is_some() || b.mesh.is_some() {
                    return None;
                }
                let alike = core::ptr::eq(a.law, b.law) && (a.integrate, a.stride) == (b.integrate, b.stride);
                let [last, next] = [a.links[a.links.len() - 1], b.links[0]].map(|l| self.ends(l)[0]);
                let gap = next.checked_sub(last + 1).filter(|_| alike && b.stride > 0 && b.law.wide)? as usize;
                let stride = b.stride as u32;
                let worth = || {
                    let free = is_free(last + 1, next) && is_free(last + 1 + stride, next + stride);
                    gap <= 1 || cost::joins(gap, b.law.coefs) && free
                };
                (if b.integrate == Integrate::No { worth() } else { gap <= 1 }).then_some(gap)
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
}
