//! Sorted: links of one law in the order of rows, where the document has them in another.
//!
//! A mesh may be written row by row, node by node, column by column or in no order: it is the same mesh, and rows are found
//! only in links that follow each other. Decides to keep the order of the document, which is that of the sums, wherever as
//! many links of it stand in rows and no row along comes behind one across at the same mass; else to sort by stride and
//! then by place, so that the forces on a mass are summed as those of a mesh that is written along its rows first. Only of
//! links that are written one by one: what a generator made stands as it should.

use crate::emit::plan::Plan;
use alloc::vec::Vec;
use ca_core::kind::Role;

impl Plan<'_> {
    /// The links of one law and measure, those written one by one sorted where that makes more of them stand in rows of at
    /// least `shortest` links, whose ends are `step` slots further from one link to the next.
    pub fn sorted(&self, links: Vec<u32>, shortest: usize, step: u32) -> Vec<u32> {
        let stride = |l: u32| {
            let [a, b] = self.ends(l);
            b.wrapping_sub(a)
        };
        let follows = |a: &u32, b: &u32| self.follows(*a, *b, step);
        let is_row = |row: &[u32]| row.len() >= shortest && stride(row[0]) < u32::MAX / 2;
        let in_rows =
            |links: &[u32]| links.chunk_by(follows).filter(|row| is_row(row)).map(<[u32]>::len).sum::<usize>();
        let listed = in_rows(&links);
        let mut across = alloc::vec![false; self.coef_slots()];
        let mut turns = false;
        for row in links.chunk_by(follows).filter(|row| is_row(row)) {
            let along = stride(row[0]) == step;
            for slot in row.iter().flat_map(|l| self.ends(*l)) {
                turns |= along && across[slot as usize];
                across[slot as usize] |= !along;
            }
        }
        if listed == links.len() && !turns {
            return links;
        }
        let by_hand = |l: &u32| {
            let item = self.net.lias[*l as usize].item;
            matches!(self.net.items[item as usize].kind.role, Role::Lia(_))
        };
        let mut sorted = links.clone();
        sorted.sort_by_key(|l| by_hand(l).then(|| (stride(*l), self.ends(*l)[0])));
        if turns || in_rows(&sorted) > listed { sorted } else { links }
    }
}
