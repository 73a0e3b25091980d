//! Added: the batches of links that add to the force on each slot, in order, and other forces on it.
//!
//! It shows which sums may be computed in another way: a floating-point sum depends on its order, and a scene must not.

use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::batch::Batch;
use crate::net::waveguides::WaveguideNode;
use crate::net::{End, MatRole, OutputTap};
use alloc::vec::Vec;
use ca_core::internal::op::layout::MeasureKind;

/// Forces added to all slots.
pub struct Added {
    /// First entry of each slot in `by`, and the end of the last.
    start: Vec<u32>,
    /// Batch numbers, one entry per force, in the order of the list.
    by: Vec<u32>,
    /// Number of other forces added after the links.
    behind: Vec<u8>,
    /// True for slots whose sum is read, or that get forces before the links or from links not on a line.
    whole: Vec<bool>,
}

impl Added {
    /// Collects the forces of the links of `batches`, and all others.
    pub fn new(builder: &LayoutBuilder, batches: &[Batch]) -> Added {
        let n = builder.coef_slots();
        let (behind, mut whole) = (alloc::vec![0u8; n], alloc::vec![false; n]);
        let plain = |batch: &Batch| {
            let shape = builder.shape(batch.links[0], batch.law);
            let sets = builder.net.lias[batch.links[0] as usize].sets.is_some();
            shape.measure == MeasureKind::Line && shape.onto.is_none() && !sets
        };
        let lined: Vec<bool> = batches.iter().map(plain).collect();
        let forces = || {
            let lined = batches.iter().zip(&lined).enumerate().filter(|(_, (_, lined))| **lined);
            lined.flat_map(|(i, (b, _))| {
                b.links.iter().flat_map(move |l| builder.ends(*l).map(|slot| (slot as usize, i)))
            })
        };
        let mut start = alloc::vec![0u32; n + 1];
        forces().for_each(|(slot, _)| start[slot + 1] += 1);
        (0..n).for_each(|i| start[i + 1] += start[i]);
        let (mut next, mut by) = (start.clone(), alloc::vec![0u32; start[n] as usize]);
        for (slot, i) in forces() {
            by[next[slot] as usize] = i as u32;
            next[slot] += 1;
        }
        for (batch, _) in batches.iter().zip(&lined).filter(|(_, lined)| !**lined) {
            let ends = batch.links.iter().flat_map(|l| builder.net.lias[*l as usize].all_ends());
            ends.for_each(|end| mark(&mut whole, builder.at(end), 3));
        }
        let mut all = Added { start, by, behind, whole };
        all.other_forces(builder);
        all
    }

    /// Adds moving points, weight, ports, and the slots whose sum is read.
    fn other_forces(&mut self, builder: &LayoutBuilder) {
        let net = builder.net;
        for (push, slot) in net.pushes.iter().filter_map(|p| Some((p, builder.alive(p.end, p.axis)?))) {
            let slot = slot as usize;
            self.whole[slot] |= !net.pushes_line(push);
            self.behind[slot] = self.behind[slot].saturating_add(1);
        }
        for (p, slot) in net.points.iter().zip(&builder.point).filter(|(_, slot)| **slot != u32::MAX) {
            let slot = *slot as usize;
            // A point without forces passes none on.
            let touched = self.whole[slot] || self.behind[slot] > 0 || !self.of(slot).is_empty();
            for m in net.families.of(&p.family).nodes {
                let node = builder.slot[*m as usize] as usize;
                self.whole[node] |= p.shape.is_some();
                self.behind[node] = self.behind[node].saturating_add(u8::from(touched));
            }
        }
        for (m, slot) in net.mats.iter().zip(&builder.slot).filter(|(_, slot)| **slot != u32::MAX) {
            let weighed = !m.is_fixed() && net.medium(m).gravity.iter().any(|g| *g != 0.0);
            if weighed || matches!(m.role, MatRole::Port(..) | MatRole::Slow) {
                mark(&mut self.whole, *slot, m.slots() as usize);
            }
        }
        let read = net.outs.iter().filter_map(|o| match o.tap {
            OutputTap::ForceOn(e) => builder.alive(e, o.axis),
            _ => None,
        });
        let junctions = net.lines.iter().filter(|l| l.tuned.is_some()).flat_map(WaveguideNode::junctions);
        let junctions = junctions.filter_map(|m| builder.alive(End::Mat(m), 0));
        read.chain(junctions).for_each(|slot| mark(&mut self.whole, slot, 1));
    }

    /// Returns the batches that add to a slot, one entry per force.
    pub fn of(&self, slot: usize) -> &[u32] {
        &self.by[self.start[slot] as usize..self.start[slot + 1] as usize]
    }

    /// Returns whether the sum on a slot begins with all forces of batches that have a stage, in stage order, and at
    /// most one more number follows.
    pub fn begins(&self, slot: usize, stage: impl Fn(usize) -> Option<u8>) -> bool {
        let stages = self.of(slot).iter().map(|i| stage(*i as usize));
        let first = stages.clone().take_while(Option::is_some);
        let n = first.clone().count();
        let behind = stages.clone().skip(n);
        !self.whole[slot]
            && first.is_sorted()
            && behind.clone().all(|s| s.is_none())
            && behind.count() + usize::from(self.behind[slot]) <= 1
    }
}

fn mark(whole: &mut [bool], slot: u32, axes: usize) {
    whole.iter_mut().skip(slot as usize).take(axes).for_each(|w| *w = true);
}
