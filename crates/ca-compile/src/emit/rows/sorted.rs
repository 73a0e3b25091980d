//! Sorted: links in the order of rows, whatever order the document has them in.
//!
//! A mesh may be written row by row, node by node, column by column or in no order, and a hammer before or behind it: it is the
//! same mesh. Rows are found in links that follow each other, and fused where nothing is added before them. Decides that linear
//! links on a line come first, and that of each law those written one by one stand by stride and then by place where that makes
//! rows; the forces on a mass are summed in this order. What a generator made stands as it should, and links of
//! which no rows can be made keep the order of the document.

use crate::emit::plan::Plan;
use alloc::vec::Vec;
use ca_core::kind::Role;

impl Plan<'_> {
    /// The links of one law and measure, if they stand otherwise than listed: those written one by one sorted, where some then
    /// stand in rows of at least `shortest` links, whose ends are `step` slots further from one link to the next.
    pub fn sorted(&self, links: &[u32], shortest: usize, step: u32) -> Option<Vec<u32>> {
        let stride = |l: u32| {
            let [a, b] = self.ends(l);
            b.wrapping_sub(a)
        };
        let by_hand = |l: &u32| {
            let item = self.net.lias[*l as usize].item;
            matches!(self.net.items[item as usize].kind.role, Role::Lia(_))
        };
        let key = |l: &u32| by_hand(l).then(|| (stride(*l), self.ends(*l)[0]));
        if links.is_sorted_by_key(key) {
            return None;
        }
        let mut sorted = links.to_vec();
        sorted.sort_by_key(key);
        let in_rows = |links: &[u32]| {
            let rows = links.chunk_by(|a, b| self.follows(*a, *b, step));
            let long = rows.filter(|row| row.len() >= shortest && stride(row[0]) < u32::MAX / 2);
            long.map(<[u32]>::len).sum::<usize>()
        };
        let all = in_rows(&sorted);
        (all > 0 && all >= in_rows(links)).then_some(sorted)
    }
}
