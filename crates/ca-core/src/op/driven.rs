//! Numbers of the model that a port drives, such as the pressure of a bow.
//!
//! Decides that the tick looks up coefficients in a table, which the compiler made by the functions that [`Controls`](crate::live::Controls)
//! uses: laws are written for a compiler, and derive coefficients by roots and generators that no tick has time for. A port is looked at
//! once a gesture frame, and coefficients go to what it says in a straight line over the frame, as those of a live parameter do.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::substep::phase;
use crate::state::State;

pub use crate::op::layout::Driven;

/// Turns what ports drive, at the first tick of a gesture frame. A port that is not finite drives nothing.
pub fn drive<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    if phase(layout.rates.frame, s.tick) > 1 {
        return;
    }
    // at once where nothing has sounded yet
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
            s.turn(*place as usize, R::inner(a + R::Outer::of(part) * (b - a)), ticks);
        }
    }
}
