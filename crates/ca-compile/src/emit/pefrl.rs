//! PEFRL: what its tick runs ([`ca_core::method::pefrl`]).

use alloc::vec::Vec;
use ca_core::method::pefrl::{DRIFTS, KICKS, drift, kick, kick_own};
use ca_core::op::layout::Layout;
use ca_core::op::{Kernel, Op, pass};

/// What moves masses: drifts, and between them the `forces` again and a kick. `own`: there are springs of cells.
pub fn moves(layout: &Layout, forces: &[Op], own: bool) -> Vec<Op> {
    let (n, points) = (layout.n_mat, layout.moving_points.len());
    if n == 0 {
        return Vec::new();
    }
    let kick: Kernel = if own { kick_own } else { kick };
    // what a port refuses was counted at the beginning of the tick
    let again = |op: &Op| if op.name == "ENF" { Op { kernel: pass::enf::<false>, ..*op } } else { *op };
    let mut list = Vec::new();
    for first in 0..DRIFTS.len() {
        list.push(Op { first, ..Op::pass("drift", drift, n) });
        if first < KICKS.len() {
            list.extend((points > 0).then(|| Op::pass("points", pass::project, points)));
            list.extend(forces.iter().map(again));
            list.push(Op { first, ..Op::pass("kick", kick, n) });
        }
    }
    list.push(Op::pass("flush", pass::flush, n));
    list
}
