//! Fans: lists of links from one slot to consecutive slots, or between two lists of consecutive slots, e.g. twelve
//! keys, hammers and notes written as lists.
//!
//! This step uses slots only, after all steps that move them, and only divides batches. Links stay in their order, so
//! that the order of forces on each mass is kept. MATs return to document order ([`settled`](LayoutBuilder::settled)) if that
//! makes such lists: the storage order places a note after its hammer, which helps rows only.

use crate::emit::cost;
use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::batch::Batch;
use crate::emit::rows::batches::SHORTEST_RUN;
use crate::net::{End, MatNode};
use crate::options::{KernelClass, Options};
use alloc::collections::BTreeSet;
use alloc::vec::Vec;
use ca_core::internal::op::Hub;

impl LayoutBuilder<'_> {
    /// Returns the order in which MATs outside the rows of `batches` are in document order, if nothing else depends on
    /// their slots. Returns `None` if this does not make fans.
    pub fn settled(&self, order: &[u32], options: &Options, batches: &[Batch]) -> Option<Vec<u32>> {
        let net = self.net;
        let staged = batches.iter().any(|b| b.law.implicit || !b.law.stage.is_explicit());
        if options.kernel != KernelClass::Fast || staged || net.as_milib || net.is_composed() {
            return None;
        }
        let mut free = alloc::vec![true; self.coef_slots()];
        for row in batches.iter().filter(|b| b.stride > 0) {
            let slots = || row.links.iter().flat_map(|l| self.ends(*l));
            let (Some(from), Some(to)) = (slots().min(), slots().max()) else { continue };
            free[from as usize..=to as usize].fill(false);
        }
        let moves: BTreeSet<u32> =
            net.points.iter().flat_map(|p| net.families.of(&p.family).nodes.iter().copied()).collect();
        let looked_up = batches.iter().filter(|b| b.law.wide && b.is_looked_up(self));
        let ends = looked_up.flat_map(|b| &b.links).flat_map(|l| net.lias[*l as usize].ends);
        let ended: BTreeSet<u32> = ends.filter_map(|e| if let End::Mat(m) = e { Some(m) } else { None }).collect();
        let is_free = |m: u32| {
            let slots = net.mats[m as usize].slots();
            slots == 1 && free[self.slot[m as usize] as usize] && ended.contains(&m) && !moves.contains(&m)
        };
        let places: Vec<usize> = (0..order.len()).filter(|i| is_free(order[*i])).collect();
        let mut mats: Vec<u32> = places.iter().map(|i| order[*i]).collect();
        if mats.is_sorted() {
            return None;
        }
        mats.sort_unstable();
        let mut now = order.to_vec();
        places.iter().zip(&mats).for_each(|(i, m)| now[*i] = *m);
        let settled = LayoutBuilder::new(net, &now);
        let looked_up = batches.iter().filter(|b| b.law.wide && b.is_looked_up(&settled));
        looked_up.flat_map(|b| settled.cut(b)).any(|part| part.1 != Part::Single).then_some(now)
    }

    /// Returns the slot in `to` of each slot of this plan, whose MATs are in another order.
    pub fn moved(&self, to: &LayoutBuilder) -> Vec<u32> {
        let mut all = alloc::vec![0; self.coef_slots()];
        let mats = self.net.mats.iter().map(MatNode::slots).zip(self.slot.iter().zip(&to.slot));
        let points = self.point.iter().zip(&to.point).map(|places| (1, places));
        for (n, (from, to)) in mats.chain(points).filter(|(_, (from, _))| **from != u32::MAX) {
            (0..n).for_each(|k| all[(from + k) as usize] = to + k);
        }
        all
    }

    /// Divides batches of laws with vector kernels if some of their links are a fan.
    pub fn fanned(&self, options: &Options, batches: Vec<Batch>) -> Vec<Batch> {
        let mut all = Vec::with_capacity(batches.len());
        for batch in batches {
            if options.kernel != KernelClass::Fast || !batch.law.wide || !batch.is_looked_up(self) {
                all.push(batch);
                continue;
            }
            for (links, part) in self.cut(&batch) {
                let (stride, hub) = match part {
                    Part::Single => (0, Hub::None),
                    Part::Run(stride) => (stride, Hub::None),
                    Part::Fan(hub) => (0, hub),
                };
                all.push(Batch { links, stride, hub, ..batch });
            }
        }
        all
    }

    /// Divides the links of a batch into parts, without reordering.
    fn cut(&self, batch: &Batch) -> Vec<(Vec<u32>, Part)> {
        let links = &batch.links;
        let mut all: Vec<(Vec<u32>, Part)> = Vec::new();
        let mut at = 0;
        while at < links.len() {
            let behind_singles = matches!(all.last(), Some((_, Part::Single)));
            let (n, part) = self.part(&links[at..], |n| cost::fans(n, batch.law.coefs, behind_singles));
            match all.last_mut() {
                Some((singles, Part::Single)) if part == Part::Single => singles.extend(&links[at..at + n]),
                _ => all.push((links[at..at + n].to_vec(), part)),
            }
            at += n;
        }
        all
    }

    /// Returns the first part of some links that is cheaper as a pass, else the first link alone.
    fn part(&self, links: &[u32], worth: impl Fn(usize) -> bool) -> (usize, Part) {
        let [first, second] = self.ends(links[0]);
        let along = |steps: [u32; 2]| {
            let here = |(i, l): &(usize, &u32)| {
                let i = *i as u32;
                self.ends(**l) == [first + steps[0] * i, second + steps[1] * i]
            };
            links.iter().enumerate().take_while(here).count()
        };
        // The hub must be outside its row.
        let apart = |hub: u32, row: u32, n: usize| hub < row || hub >= row + n as u32;
        let (run, from_first, from_second) = (along([1, 1]), along([0, 1]), along([1, 0]));
        match () {
            () if run >= SHORTEST_RUN && second > first => (run, Part::Run((second - first) as usize)),
            () if worth(from_first) && apart(first, second, from_first) => (from_first, Part::Fan(Hub::First)),
            () if worth(from_second) && apart(second, first, from_second) => (from_second, Part::Fan(Hub::Second)),
            () => (1, Part::Single),
        }
    }
}

/// Form of consecutive links.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Looked up one by one.
    Single,
    /// A row of this stride.
    Run(usize),
    /// From one slot to a row.
    Fan(Hub),
}
