//! A sample of several ticks: the ticks between samples, what is given once a sample, and the count of both.
//!
//! Sample n stands at tick nR. Decides that outside of the passes a state counts samples, so that takes, gestures and
//! whoever plays need not know, and that in them it counts ticks, so that rings and frames need not; and that what is
//! given at a sample is reached in a straight line from the sample before, as by a hand at the border, since a jump of
//! a port is a blow.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// Tick within a frame of `n`, 1 … n; 0 at the very first tick, which only places what is moved from outside.
pub(crate) fn phase(n: u32, tick: u64) -> u32 {
    if tick == 0 { 0 } else { ((tick - 1) % u64::from(n)) as u32 + 1 }
}

/// Runs the ticks between the sample before and this one, and counts ticks from there on. The first sample has none.
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

/// Moves what is given once a sample a tick further. What is not finite is refused here: a position stays, a force is
/// none.
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

/// From here on the state counts ticks.
pub fn to_ticks<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    s.tick *= u64::from(layout.oversample());
}

/// From here on the state counts samples.
pub fn to_samples<R: Real>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    s.tick /= u64::from(layout.oversample());
}
