//! Border with one tick per frame: sends the force of the tick itself.
//!
//! The mean with the tick before would conserve power exactly but delay the force by half a frame. At one rate there is
//! nothing to resample, and the papers assume this delay.

use super::{begin, place};
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

pub(super) fn position<R: Real, const LATE: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let ports = &layout.ports.tgr[..op.n];
    begin::<R, LATE>(layout, s, ports);
    place(s, ports, |b| b.to);
}

/// Takes the force of this tick. The first tick only places the device and gives none.
pub(super) fn collect<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    if s.tick == 0 {
        return;
    }
    for (k, p) in layout.ports.tgr[..op.n].iter().enumerate() {
        s.ports.border[k].force = s.f[p.mat as usize].wide();
    }
}
