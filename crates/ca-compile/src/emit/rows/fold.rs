//! Fold: long rows that integrate their masses are stored as eight adjacent stretches ([`Fold`]), padded to whole
//! vectors.
//!
//! This step runs when the masses are otherwise complete and before anything is laid out by their slots, so that later
//! steps do not depend on it. A folded row begins at a multiple of eight, so that its vectors do not cross cache lines;
//! with vectors of eight this saves a third of the time. In single precision rows are not folded.

use crate::emit::cost;
use crate::emit::layout_builder::LayoutBuilder;
use crate::emit::masses::Masses;
use crate::emit::pass_list::{self, Class};
use crate::emit::rows::batch::{Batch, JOINT, Mesh, can_fold};
use alloc::collections::BTreeMap;
use alloc::vec::Vec;
use ca_core::internal::op::{Band, Integrate};
use ca_core::internal::state::Fold;

/// Returns which batches are rows that [`cost`] advises to fold. Other rows at their masses lose their constant stride
/// and are looked up one by one.
fn chosen(builder: &LayoutBuilder, batches: &[Batch]) -> Vec<bool> {
    let wide = |b: &Batch| b.integrate != Integrate::No && b.law.wide;
    let mut folds: Vec<bool> = batches.iter().map(|b| can_fold(builder.net) && wide(b)).collect();
    let mut owner: Vec<u32> = alloc::vec![u32::MAX; builder.coef_slots()];
    for (i, b) in batches.iter().enumerate().filter(|(i, _)| folds[*i]) {
        owner[b.slot(builder) as usize..][..b.masses()].fill(i as u32);
    }
    // Links of other rows at each of them.
    let mut over = alloc::vec![0; batches.len()];
    let touched = |b: &Batch, visit: &mut dyn FnMut(usize)| {
        let from = b.slot(builder) as usize;
        let slots = (from..from + b.links.len()).chain(from + b.stride..from + b.stride + b.links.len());
        slots.map(|slot| owner[slot] as usize).filter(|i| *i < batches.len()).for_each(visit);
    };
    let others = || batches.iter().filter(|b| b.stride > 0 && b.integrate == Integrate::No);
    others().for_each(|b| touched(b, &mut |i| over[i] += 1));
    for (i, b) in batches.iter().enumerate() {
        folds[i] &= match b.mesh {
            None => cost::folds(b.masses(), b.law.coefs, over[i]),
            Some(mesh) => cost::bands(mesh.nodes(), b.law.coefs, over[i]),
        };
    }
    folds
}

/// A row to fold.
struct Row {
    /// First slot of its masses before folding.
    from: usize,
    /// Number of masses.
    masses: usize,
    /// Nodes, for a mesh.
    mesh: Option<Mesh>,
    /// Position after folding.
    fold: Fold,
}

impl Row {
    fn slots(&self) -> usize {
        self.fold.rows as usize * Fold::LANES
    }
}

/// Folds the rows for which this is cheaper, and lays out slots, classes and coefficients again. Returns the new
/// position of each slot; empty if no row is folded.
pub fn fold(
    builder: &mut LayoutBuilder,
    masses: &mut Masses,
    classes: &mut Vec<Option<Class>>,
    batches: &mut [Batch],
) -> Vec<u32> {
    let mut rows = Vec::new();
    let folds = chosen(builder, batches);
    for (row, _) in batches.iter_mut().zip(folds).filter(|(_, folds)| *folds) {
        let masses = row.masses();
        let nodes = row.mesh.map_or(masses, |mesh| mesh.nodes());
        let fold = Fold { first: 0, rows: nodes.div_ceil(Fold::LANES) as u32 };
        let now = Row { from: row.slot(builder) as usize, masses, mesh: row.mesh, fold };
        let mut links = alloc::vec![JOINT; now.slots()];
        for (i, l) in row.links.iter().enumerate() {
            links[fold.at(i)] = *l;
        }
        (row.links, row.stride, row.folded) = (links, 0, true);
        // Links across a mesh are stored like those along it.
        if row.band != Band::Across {
            rows.push(now);
        }
    }
    if rows.is_empty() {
        return Vec::new();
    }
    rows.sort_by_key(|r| r.from);
    let n = builder.coef_slots();
    let mut to: Vec<u32> = Vec::with_capacity(n);
    // Slots so far, and the number of slots of MATs, after which moving points begin.
    let (mut at, mut of_mats) = (0, None);
    let mut next = rows.iter_mut().peekable();
    while to.len() < n {
        let from = to.len();
        if from == classes.len() {
            of_mats = Some(at);
        }
        if let Some(row) = next.next_if(|r| r.from == from) {
            at = usize::next_multiple_of(at, Fold::LANES);
            row.fold.first = at as u32;
            let node = |i: usize| row.mesh.map_or(i, |mesh| mesh.node(i));
            to.extend((0..row.masses).map(|i| row.fold.at(node(i)) as u32));
            at += row.slots();
        } else {
            to.push(at as u32);
            at += 1;
        }
    }
    let of_mats = of_mats.unwrap_or(at);
    let at_row: BTreeMap<u32, u32> = rows.iter().map(|r| (r.from as u32, r.fold.first)).collect();
    let slots = at.next_multiple_of(Fold::LANES);
    // Other rows may have another stride now, or none.
    for b in batches.iter_mut().filter(|b| b.stride > 0) {
        let [first, second] = [0, b.stride].map(|more| &to[b.slot(builder) as usize + more..][..b.links.len()]);
        let in_a_row = [first, second].iter().all(|ends| ends.windows(2).all(|pair| pair[1] == pair[0] + 1));
        b.stride = if in_a_row { (second[0] - first[0]) as usize } else { 0 };
    }
    for slot in builder.slot.iter_mut().chain(&mut builder.point).filter(|s| **s != u32::MAX) {
        *slot = to[*slot as usize];
    }
    for mesh in batches.iter_mut().filter_map(|b| b.mesh.as_mut()) {
        // The place of the first node, which an incomplete first row may lack.
        mesh.first = at_row[&mesh.first];
    }
    let column = |all: &[f64]| {
        let mut now = alloc::vec![0.0; slots];
        all.iter().zip(&to).for_each(|(v, to)| now[*to as usize] = *v);
        now
    };
    for all in [&mut masses.x, &mut masses.v, &mut masses.rest] {
        *all = column(all);
    }
    builder.coef = builder.coef.chunks_exact(n).flat_map(column).collect();
    for coef in &mut builder.live {
        let (column, slot) = (*coef as usize / n, *coef as usize % n);
        *coef = (column * slots) as u32 + to[slot];
    }
    let mut now = alloc::vec![None; of_mats];
    classes.iter().zip(&to).for_each(|(class, to)| now[*to as usize] = *class);
    // A row is integrated as a whole, including padding, which may come first.
    for row in &rows {
        now[row.fold.first as usize..][..row.slots()].fill(classes[row.from]);
    }
    pass_list::fill_classes(&mut now);
    *classes = now;
    to
}
