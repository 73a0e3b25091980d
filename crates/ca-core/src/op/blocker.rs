//! Outputs without their steady part: a one-pole high pass, y ← r·y + g·(v − v′).
//!
//! Decides on the bilinear one: −3 dB exactly at the cut-off and 0 dB at half the sound rate. It stands on the output
//! and not on the channel, since several outputs of different cut-off may share one; and that what is heard at load
//! has always been there, so that a spring under tension makes no thump.

use super::Op;
use super::pass::Heard;
use crate::numeric::{TINY, wide};
use crate::op::layout::Layout;
use crate::state::State;

/// Adds the outputs from `op.first` on, each through its high pass.
pub fn blocker(op: &Op, layout: &Layout, s: &mut State) {
    for (k, (o, c)) in layout.outputs[op.first..].iter().zip(&layout.blockers[..op.n]).enumerate() {
        let v = s.coef[op.coef + k] * Heard::of(s).by(o);
        let [before, y] = if s.tick == 0 { [v, 0.0] } else { s.blocked[k] };
        let y = c.r * y + c.g * (v - before);
        let y = if y.abs() < TINY { 0.0 } else { y };
        s.blocked[k] = [v, y];
        s.output[o.channel as usize] += wide(y);
    }
}
