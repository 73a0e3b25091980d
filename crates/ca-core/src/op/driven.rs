//! Model parameters driven by a port, such as the pressure of a bow.
//!
//! The tick interpolates coefficients in a table, which the compiler made with the functions of
//! [`Controls`](crate::live::Controls); the roots and generators of laws are too slow for a tick. A port is read once
//! per gesture frame, and coefficients ramp over the frame, like those of a live parameter.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::substep::phase;
use crate::state::State;

pub use crate::op::layout::Driven;

/// Starts the ramps at the first tick of a gesture frame. A port value that is not finite has no effect.
pub fn drive<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    if phase(layout.rates.frame, s.tick) > 1 {
        return;
    }
    // in one tick at the start, before anything has sounded
    let ticks = if s.tick == 0 { 1 } else { layout.rates.frame };
    for d in &layout.ports.driven {
        let [from, to] = d.span;
        let at = (s.input[d.input as usize] - from) / (to - from);
        if !at.is_finite() {
            continue;
        }
        let at = at.clamp(0.0, 1.0) * (d.rows - 1) as f64;
        let row = (at as usize).min(d.rows - 2);
        let (part, n) = (at - row as f64, d.places.len());
        let (below, above) = (&d.table[row * n..][..n], &d.table[(row + 1) * n..][..n]);
        for ((place, a), b) in d.places.iter().zip(below).zip(above) {
            let (a, b) = (a.outer(), b.outer());
            s.ramp_to(*place as usize, R::inner(a + R::Outer::of(part) * (b - a)), ticks);
        }
    }
}
