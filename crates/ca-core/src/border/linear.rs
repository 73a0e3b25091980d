//! Linear position, trapezoid mean force: the default border.

use super::{begin, phase, place};
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Position of device ports at this tick, on the straight line through the frame.
pub(super) fn position<R: Real, const LATE: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let (j, ports) = (phase(layout.rates.frame, s.tick), &layout.ports.tgr[..op.n]);
    if j <= 1 {
        begin::<R, LATE>(layout, s, ports);
    }
    if j == layout.rates.frame || j == 0 {
        place(s, ports, |b| b.to);
    } else {
        let part = f64::from(j) / f64::from(layout.rates.frame);
        place(s, ports, |b| b.from + part * (b.to - b.from));
    }
}

/// The mean over the frame, its first and last force counted half.
pub(super) fn collect<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let j = phase(layout.rates.frame, s.tick);
    let f = &s.f[..];
    let each = layout.ports.tgr[..op.n].iter().map(|p| f[p.mat as usize].wide()).zip(&mut s.ports.border);
    if j == layout.rates.frame {
        for (f, b) in each {
            b.force = (b.sum + 0.5 * f) / f64::from(layout.rates.frame);
            b.sum = 0.5 * f;
        }
    } else if j == 0 {
        each.for_each(|(f, b)| b.sum = 0.5 * f);
    } else {
        each.for_each(|(f, b)| b.sum += f);
    }
}
