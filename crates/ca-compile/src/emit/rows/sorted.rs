//! Sorted: links in the order of rows, whatever order the document has them in.
//!
//! A mesh may be written row by row, node by node, column by column or in no order, and a hammer before or behind it: it is the
//! same mesh. Rows are found in links that follow each other, and fused where nothing is added before them. Decides that linear
//! links on a line come first, and that of each law those written one by one, or as lists that are rows, come by stride and then
//! by place, before those that stand in no row; the forces on a mass are summed in this order. What a generator made
//! stands as it should.

use crate::emit::plan::Plan;
use alloc::vec::Vec;
use ca_core::Role;

/// Links in a row, at least; rows that are too short to run as such still have their order.
const SHORTEST: usize = 2;

impl Plan<'_> {
    /// The links of one law and measure, if they stand otherwise than listed: where some of those written one by one then stand
    /// in rows of at least `shortest` links, whose ends are `step` slots further from one link to the next.
    pub fn sorted(&self, links: &[u32], shortest: usize, step: u32) -> Option<Vec<u32>> {
        let stride = |l: u32| {
            let [a, b] = self.ends(l);
            b.wrapping_sub(a)
        };
        let key = |l: &u32| (stride(*l), self.ends(*l)[0]);
        let item = |l: &u32| self.net.lias[*l as usize].item;
        let by_hand = |l: &u32| matches!(self.net.items[item(l) as usize].kind.role, Role::Lia(_));
        if !links.iter().any(by_hand) {
            return None;
        }
        let follows = |a: &u32, b: &u32| self.follows(*a, *b, step);
        let (mut listed, mut made) = (Vec::new(), Vec::new());
        for of in links.chunk_by(|a, b| item(a) == item(b)) {
            // a list that is no row, as from one place to many, has the order its author gave it
            let to = if by_hand(&of[0]) && of.is_sorted_by(follows) { &mut listed } else { &mut made };
            to.extend_from_slice(of);
        }
        if listed.is_sorted_by_key(key) {
            return None;
        }
        let mut sorted = listed.clone();
        sorted.sort_by_key(key);
        let is_row = |row: &&[u32], shortest: usize| row.len() >= shortest && stride(row[0]) < u32::MAX / 2;
        // links in rows, and how many of them in long ones
        let in_rows = |links: &[u32]| {
            let rows = || links.chunk_by(follows);
            let long = rows().filter(|row| is_row(row, shortest)).map(<[u32]>::len).sum::<usize>();
            (rows().filter(|row| is_row(row, SHORTEST)).flatten().copied().collect::<Vec<u32>>(), long)
        };
        let ((was, long), (mut rows, longer)) = (in_rows(&listed), in_rows(&sorted));
        if rows == was || longer == 0 || longer < long {
            return None;
        }
        let mut taken = rows.clone();
        taken.sort_unstable();
        rows.extend(listed.iter().filter(|l| taken.binary_search(l).is_err()));
        Some([made, rows].concat())
    }
}
