//! Join: rows that run as one, with joints without force between them.
//!
//! Decides this after what integrates is known: two rows are one only where they do the same, and where every mass is given its
//! forces in the same order.

use crate::emit::cost;
use crate::emit::plan::Plan;
use crate::emit::rows::bands;
use crate::emit::rows::batch::{Batch, JOINT, Mesh};
use crate::options::{KernelClass, Options};
use alloc::vec::Vec;
use ca_core::internal::op::Integrate;

impl Plan<'_> {
    /// Rows joined to longer ones where the next begins soon behind the one before: a pass for each row of a mesh waits
    /// more than it computes. What integrates comes first, in the order of its slots; other rows only where one follows
    /// the other in the list, so that every mass is given its forces in the same order.
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
        // links across a mesh stay behind those along
        rows.sort_by_key(|b| b.slot(self));
        // joints at masses of a row that integrates them would be links of another row over it
        let taken: Vec<[u32; 2]> = rows.iter().map(|b| [b.slot(self), b.slot(self) + b.masses() as u32]).collect();
        let is_free = |from: u32, to: u32| {
            let next = taken.partition_point(|t| t[1] <= from);
            taken.get(next).is_none_or(|t| to <= t[0])
        };
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
