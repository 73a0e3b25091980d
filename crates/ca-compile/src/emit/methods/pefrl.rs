//! PEFRL: what its tick runs ([`ca_core::internal::method::pefrl`]).

use alloc::vec::Vec;
use ca_core::internal::method::pefrl::{DRIFTS, KICKS};
use ca_core::internal::op::layout::Layout;
use ca_core::internal::op::{Op, Pass};

/// What moves masses: drifts, and between them the `forces` again and a kick. `own`: there are springs of cells.
pub fn moves(layout: &Layout, forces: &[Op], own: bool) -> Vec<Op> {
    let (n, points) = (layout.counts.n_mat, layout.places.moving_points.len());
    if n == 0 {
        return Vec::new();
    }
    let kick = Pass::Kick { own };
    // what a port refuses was counted at the beginning of the tick
    let again = |op: &Op| {
        if op.name() == "ENF" { Op { first: op.first, ..Op::pass(Pass::Enf { counted: false }, op.n) } } else { *op }
    };
    let mut list = Vec::new();
    for first in 0..DRIFTS.len() {
        list.push(Op { first, ..Op::pass(Pass::Drift, n) });
        if first < KICKS.len() {
            list.extend((points > 0).then(|| Op::pass(Pass::Points, points)));
            list.extend(forces.iter().map(again));
            list.push(Op { first, ..Op::pass(kick, n) });
        }
    }
    list.push(Op::pass(Pass::Flush, n));
    list
}
