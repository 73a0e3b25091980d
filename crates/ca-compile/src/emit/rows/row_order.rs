//! Sorted: links in the order of rows, whatever their order in the document.
//!
//! A mesh may be written by rows, nodes or columns or in any order, and a hammer before or after it: the scene is the
//! same. Rows are found in consecutive links, and fused if no force is added before them. Linear links on a line
//! therefore come first. Within a law, links in rows that are written one by one, or as lists that are rows, come by
//! stride and then by slot, before links in no row. The forces on a mass are summed in this order. Links of generators
//! keep their order.

use crate::emit::layout_builder::LayoutBuilder;
use alloc::vec::Vec;
use ca_core::Role;

/// Smallest number of links in a row; rows too short for a run are sorted too.
const SHORTEST: usize = 2;

impl LayoutBuilder<'_> {
    /// Returns the links of one law and measure in sorted order, if it differs from the given one. Some links written
    /// one by one must then be in rows of at least `shortest` links, with both ends `step` slots further from link to
    /// link.
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
            // A list that is not a row, e.g. from one slot to many, keeps the order of its author.
            let to = if by_hand(&of[0]) && of.is_sorted_by(follows) { &mut listed } else { &mut made };
            to.extend_from_slice(of);
        }
        if listed.is_sorted_by_key(key) {
            return None;
        }
        let mut sorted = listed.clone();
        sorted.sort_by_key(key);
        let is_row = |row: &&[u32], shortest: usize| row.len() >= shortest && stride(row[0]) < u32::MAX / 2;
        // Links in rows, and how many of them are in long ones.
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
