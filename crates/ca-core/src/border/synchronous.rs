//! One tick a frame: the force of the tick itself, for whoever runs the whole scene at the rate of the device.
//!
//! Decides against the mean with the tick before, which would keep power exact at the price of half a frame: at one
//! rate there is nothing to resample, and this is the delay the papers take for granted.

use super::{begin, place};
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Position of device ports at this tick.
pub(super) fn position<R: Real, const LATE: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let ports = &layout.ports.tgr[..op.n];
    begin::<R, LATE>(layout, s, ports);
    place(s, ports, |b| b.to);
}

/// The force of this tick; the first, which only places the device, gives none.
pub(super) fn collect<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    if s.tick == 0 {
        return;
    }
    for (k, p) in layout.ports.tgr[..op.n].iter().enumerate() {
        s.ports.border[k].force = s.f[p.mat as usize].wide();
    }
}
