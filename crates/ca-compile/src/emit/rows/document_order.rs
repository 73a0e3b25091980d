//! DocumentOrder: the order that the numbers of the state would have if no row had been joined or folded.
//!
//! The hash of a state uses this order, which depends on the document only. Takes store these hashes, while the layout
//! of the state may change between versions of the compiler.

use crate::emit::rows::batch::Batch;
use crate::emit::rows::links::Links;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::ops::Range;

/// Original order of slots and coefficients.
#[derive(Default)]
pub struct DocumentOrder {
    /// Links of each batch before any row was joined.
    batches: Vec<Vec<u32>>,
    /// Slots in their order before any row was folded; empty if none was.
    pub slots: Vec<u32>,
    /// The same for the coefficients of MATs and links.
    coefs: Vec<u32>,
    /// First coefficient after these.
    end: usize,
}

impl DocumentOrder {
    /// Stores the batches in their present order.
    pub fn new(batches: &[Batch]) -> DocumentOrder {
        DocumentOrder { batches: batches.iter().map(|b| b.links.clone()).collect(), ..DocumentOrder::default() }
    }

    /// Records the indices of the coefficients of `n_mat` slots and of `links`.
    pub fn coefs(&mut self, n_mat: usize, of_links: Range<usize>, links: &Links) {
        let slots = &self.slots;
        let slot = |i: usize| slots.get(i).map_or(i, |s| *s as usize);
        let listed = if slots.is_empty() { n_mat } else { slots.len() };
        let of_mats = (0..3).flat_map(|k| (0..listed).map(move |i| (k * n_mat + slot(i)) as u32));
        self.coefs = of_mats.chain((3 * n_mat) as u32..of_links.start as u32).collect();
        for batch in &self.batches {
            let columns = links.forces[links.where_is[batch[0] as usize].0 as usize].law.map_or(0, |law| law.coefs);
            for k in 0..columns {
                self.coefs.extend(batch.iter().map(|l| {
                    let (op, i) = links.where_is[*l as usize];
                    let op = &links.forces[op as usize];
                    (op.coef + k * op.n) as u32 + i
                }));
            }
        }
        self.end = of_links.end;
    }

    /// Returns the indices of slots and of `n_coef` coefficients in document order.
    pub fn orders(self, n_coef: usize) -> [Arc<[u32]>; 2] {
        let mut coefs = self.coefs;
        if !coefs.is_empty() {
            coefs.extend(self.end as u32..n_coef as u32);
        }
        if coefs.len() == n_coef && coefs.iter().enumerate().all(|(i, c)| i as u32 == *c) {
            coefs.clear();
        }
        [self.slots.into(), coefs.into()]
    }
}
