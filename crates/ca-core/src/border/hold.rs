//! Border with the position held during the frame, and the force of the edge at which it jumps.
//!
//! All motion of the frame happens between its first tick and the tick before, and half of the force at each acts on
//! it. The mean of these two forces is the only one that conserves power exactly. The force at the first tick alone
//! would respond half a frame sooner and make energy, 3 % of the energy that crosses (docs/numerics.md §5.1).

use super::{begin, phase, place};
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

pub(super) fn position<R: Real, const LATE: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let ports = &layout.ports.tgr[..op.n];
    if phase(layout.rates.frame, s.tick) <= 1 {
        begin::<R, LATE>(layout, s, ports);
    }
    place(s, ports, |b| b.to);
}

/// Takes the mean of the last force before the jump and the first after it. [`Border::sum`](crate::state::Border::sum)
/// holds the last force of the frame before, then this mean until the frame ends.
pub(super) fn collect<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let j = phase(layout.rates.frame, s.tick);
    for (k, p) in layout.ports.tgr[..op.n].iter().enumerate() {
        let f = s.f[p.mat as usize].wide();
        let b = &mut s.ports.border[k];
        if j == 0 {
            b.sum = f;
        } else if j == 1 {
            b.sum = 0.5 * (b.sum + f);
        } else if j == layout.rates.frame {
            b.force = b.sum;
            b.sum = f;
        }
    }
}
