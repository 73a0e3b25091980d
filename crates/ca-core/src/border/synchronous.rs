//! One tick a frame: the force of the tick itself, for whoever runs the whole scene at the rate of the device.
//!
//! Decides against the mean with the tick before, which would keep power exact at the price of half a frame: at one
//! rate there is nothing to resample, and this is the delay the papers take for granted.

use super::{begin, place};
use crate::numeric::wide;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::state::State;

/// Position of device ports at this tick.
pub(super) fn position<const LATE: bool>(op: &Op, layout: &Layout, s: &mut State) {
    let ports = &layout.tgr[..op.n];
    begin::<LATE>(layout, s, ports);
    place(s, ports, |b| b.to);
}

/// The force of this tick; the first, which only places the device, gives none.
pub(super) fn collect(op: &Op, layout: &Layout, s: &mut State) {
    if s.tick == 0 {
        return;
    }
    for (k, p) in layout.tgr[..op.n].iter().enumerate() {
        s.border[k].force = wide(s.f[p.mat as usize]);
    }
}
