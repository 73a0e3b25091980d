//! PEFRL: the passes of its tick ([`ca_core::internal::method::pefrl`]).

use alloc::vec::Vec;
use ca_core::internal::method::pefrl::{DRIFTS, KICKS};
use ca_core::internal::op::layout::Layout;
use ca_core::internal::op::{Op, Pass};

/// Returns the passes that move masses: drifts, and between them `forces` again and a kick. `own` is true if there are
/// cells with springs.
pub fn moves(layout: &Layout, forces: &[Op], own: bool) -> Vec<Op> {
    let (n, points) = (layout.counts.n_mat, layout.places.moving_points.len());
    if n == 0 {
        return Vec::new();
    }
    let kick = Pass::Kick { own };
    // Refused inputs of ports were counted at the beginning of the tick.
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
