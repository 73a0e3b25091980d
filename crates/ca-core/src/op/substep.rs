//! A sample of several ticks: the ticks between samples, inputs given once per sample, and the count of both.
//!
//! Sample n is at tick nR. Outside the passes a state counts samples, for takes, gestures and players. Within the
//! passes it counts ticks, for rings and frames. An input moves to its new value in a straight line from the sample
//! before, as at the border, since a jump of a port is a blow.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// Returns the tick within a frame of `n`, 1 … n, or 0 at the very first tick, which only sets positions.
pub(crate) fn phase(n: u32, tick: u64) -> u32 {
    if tick == 0 { 0 } else { ((tick - 1) % u64::from(n)) as u32 + 1 }
}

/// Runs the ticks between the last sample and this one, if there was one, and counts ticks from there on.
pub fn between<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(substeps) = &layout.rates.substeps else { return };
    let now = s.tick * u64::from(substeps.times);
    s.tick = (now + 1).saturating_sub(u64::from(substeps.times));
    while s.tick < now {
        for op in &*substeps.tick {
            (op.kernel)(op, layout, s);
        }
        s.tick += 1;
    }
}

/// Moves inputs given once per sample by one tick. One that is not finite is refused: a position stays, a force is
/// zero.
pub fn inputs<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some(substeps) = &layout.rates.substeps else { return };
    let j = phase(substeps.times, s.tick);
    for (g, i) in s.ports.glide[..op.n].iter_mut().zip(&substeps.inputs) {
        let v = &mut s.input[*i as usize];
        if j <= 1 {
            let to = if v.is_finite() {
                *v
            } else {
                s.ports.refused += 1;
                if layout.ports.enf.iter().any(|p| p.input == *i) { 0.0 } else { g[1] }
            };
            *g = [if j == 0 { to } else { g[1] }, to];
        }
        let [from, to] = *g;
        *v = if j == 0 || j == substeps.times {
            to
        } else {
            from + f64::from(j) / f64::from(substeps.times) * (to - from)
        };
    }
}

/// Switches the state to counting ticks.
pub fn to_ticks<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    s.tick *= u64::from(layout.oversample());
}

/// Switches the state to counting samples.
pub fn to_samples<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    s.tick /= u64::from(layout.oversample());
}
