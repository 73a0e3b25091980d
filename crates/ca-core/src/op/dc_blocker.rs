//! Outputs without their constant part: a one-pole high-pass, y ← r·y + g·(v − v′).
//!
//! It is bilinear: exactly −3 dB at the cut-off and 0 dB at half the sound rate. Each output has its own, since outputs
//! with different cut-offs may share a channel. It starts settled, so a spring under tension makes no thump.

use super::Op;
use super::pass::Signals;
use crate::numeric::Real;
use crate::op::layout::{DcBlocker, Layout, Tap};
use crate::state::State;

/// Adds the outputs from `op.first` on, each through its high-pass.
pub fn blocker<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for (k, (o, c)) in layout.out.outputs[op.first..].iter().zip(&layout.out.blockers[..op.n]).enumerate() {
        let v = s.coef[op.coef + k] * Signals::of(s).read(o);
        let y = step(*c, &mut s.ports.blocked[k], s.tick, v);
        s.output[o.channel as usize] += y.outer();
    }
}

/// Adds the last outputs, from `op.first` on, which are outputs of motion.
pub fn of_motion<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let before = layout.out.blockers.len() - op.n;
    for (k, (o, c)) in layout.out.outputs[op.first..].iter().zip(&layout.out.blockers[before..]).enumerate() {
        let Tap::Position(m) = o.tap else { continue };
        let v = s.coef[op.coef + k] * s.d[m as usize];
        let y = step(*c, &mut s.ports.blocked[before + k], s.tick, v);
        s.output[o.channel as usize] += y.outer();
    }
}

#[inline(always)]
fn step<R: Real>(c: DcBlocker<R>, kept: &mut [R; 2], tick: u64, v: R) -> R {
    let [before, y] = if tick == 0 { [v, R::ZERO] } else { *kept };
    let y = c.r * y + c.g * (v - before);
    let y = if y.abs() < R::TINY { R::ZERO } else { y };
    *kept = [v, y];
    y
}
