//! Linear position, trapezoid mean force: the default border.

use super::{begin, phase, place};
use crate::numeric::wide;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Position of device ports at this tick, on the straight line through the frame.
pub(super) fn position<const LATE: bool>(op: &Op, layout: &Layout, s: &mut State) {
    let j = phase(layout.frame, s.tick);
    for (k, p) in layout.tgr[..op.n].iter().enumerate() {
        if j <= 1 {
            begin::<LATE>(layout, s, k, p);
        }
        let b = s.border[k];
        let x = if j == layout.frame || j == 0 {
            b.to
        } else {
            b.from + f64::from(j) / f64::from(layout.frame) * (b.to - b.from)
        };
        place(s, p, x);
    }
}

/// The mean over the frame, its first and last force counted half.
pub(super) fn collect(op: &Op, layout: &Layout, s: &mut State) {
    let j = phase(layout.frame, s.tick);
    for (k, p) in layout.tgr[..op.n].iter().enumerate() {
        let f = wide(s.f[p.mat as usize]);
        let b = &mut s.border[k];
        if j == layout.frame {
            b.force = (b.sum + 0.5 * f) / f64::from(layout.frame);
            b.sum = 0.5 * f;
        } else if j == 0 {
            b.sum = 0.5 * f;
        } else {
            b.sum += f;
        }
    }
}
