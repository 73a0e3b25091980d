//! Chains: short rows close behind each other, e.g. in a mesh of 10 × 10, run as one.
//!
//! This step follows the batches, because each of these rows is too short for a run, and the document order of state
//! hashes ([`document_order`](super::document_order)) depends on the batches and must not change. The order of forces on each mass is
//! kept: a row stays among the links that are looked up if one of these comes before it at one of its masses.

use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::rows::batch::Batch;
use crate::emit::rows::batches::SHORTEST_RUN;
use crate::options::{KernelClass, Options};
use alloc::collections::BTreeSet;
use alloc::vec::Vec;

/// Largest gap between two rows of a chain \[slots\]: the mass at which the first one ends.
const GAP: u32 = 1;

impl LayoutBuilder<'_> {
    /// Returns the batches, with the chains of each before the rest of it.
    pub fn chained(&self, options: &Options, batches: Vec<Batch>) -> Vec<Batch> {
        let mut all = Vec::with_capacity(batches.len());
        for batch in batches {
            if options.kernel != KernelClass::Fast || !batch.is_looked_up(self) || !batch.law.wide {
                all.push(batch);
                continue;
            }
            let (rows, singles) = self.rows_of(&batch.links);
            all.extend(rows.into_iter().map(|(links, stride)| Batch { links, stride, ..batch }));
            if !singles.is_empty() {
                all.push(Batch { links: singles, ..batch });
            }
        }
        all
    }

    /// Divides links that are looked up into rows of chains, each with its stride, and other links.
    fn rows_of(&self, links: &[u32]) -> (Vec<(Vec<u32>, usize)>, Vec<u32>) {
        let (first, last) = (|row: &[u32]| self.ends(row[0]), |row: &[u32]| self.ends(row[row.len() - 1])[0]);
        let stride = |row: &[u32]| first(row)[1].wrapping_sub(first(row)[0]);
        let behind = |a: &&[u32], b: &&[u32]| {
            let next = last(a) + 1;
            stride(a) == stride(b) && (next..=next + GAP).contains(&first(b)[0])
        };
        let (mut rows, mut singles, mut passed) = (Vec::new(), Vec::new(), BTreeSet::new());
        let short: Vec<&[u32]> = links.chunk_by(|a, b| self.follows(*a, *b, 1)).collect();
        for chain in short.chunk_by(behind) {
            let each = || chain.iter().copied().flatten().copied();
            let n = each().count();
            // At most every other link may be a joint.
            let worth = n >= SHORTEST_RUN && n >= 2 * chain.len() && stride(chain[0]) < u32::MAX / 2;
            if worth && !each().flat_map(|l| self.ends(l)).any(|slot| passed.contains(&slot)) {
                rows.extend(chain.iter().map(|row| (row.to_vec(), stride(row) as usize)));
            } else {
                passed.extend(each().flat_map(|l| self.ends(l)));
                singles.extend(each());
            }
        }
        (rows, singles)
    }
}
