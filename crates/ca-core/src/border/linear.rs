//! The default border: linear position, trapezoid mean force.

use super::{begin, phase, place};
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Sets the position of device ports at this tick, on a straight line through the frame.
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

/// Takes the mean over the frame, with half weight for its first and last force.
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
