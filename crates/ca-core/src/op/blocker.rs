//! Outputs without their steady part: a one-pole high pass, y ← r·y + g·(v − v′).
//!
//! Decides on the bilinear one: −3 dB exactly at the cut-off and 0 dB at half the sound rate. It stands on the output
//! and not on the channel, since several outputs of different cut-off may share one; and that what is heard at load
//! has always been there, so that a spring under tension makes no thump.

use super::Op;
use super::pass::Heard;
use crate::numeric::{Real, TINY, wide};
use crate::op::layout::{Layout, Output, Tap};
use crate::state::State;

/// Adds the outputs from `op.first` on, each through its high pass.
pub fn blocker(op: &Op, layout: &Layout, s: &mut State) {
    for (k, o) in layout.outputs[op.first..][..op.n].iter().enumerate() {
        let v = s.coef[op.coef + k] * Heard::of(s).by(o);
        pass(layout, s, o, k, v);
    }
}

/// The last outputs, from `op.first` on: they hear motion.
pub fn of_motion(op: &Op, layout: &Layout, s: &mut State) {
    let before = layout.blockers.len() - op.n;
    for (k, o) in layout.outputs[op.first..].iter().enumerate() {
        if let Tap::Position(m) = o.tap {
            let v = s.coef[op.coef + k] * s.d[m as usize];
            pass(layout, s, o, before + k, v);
        }
    }
}

/// Adds what high pass `k` makes of `v`.
#[inline(always)]
fn pass(layout: &Layout, s: &mut State, o: &Output, k: usize, v: Real) {
    let c = &layout.blockers[k];
    let [before, y] = if s.tick == 0 { [v, 0.0] } else { s.blocked[k] };
    let y = c.r * y + c.g * (v - before);
    let y = if y.abs() < TINY { 0.0 } else { y };
    s.blocked[k] = [v, y];
    s.output[o.channel as usize] += wide(y);
}
