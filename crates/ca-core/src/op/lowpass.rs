//! Low-pass of the sound channels: a linear-phase FIR.
//!
//! It is the direct form over a past that is stored twice, so that the window is one slice without a wrap. The symmetry
//! of the coefficients halves the products. The sound is (n−1)/2 ticks late at every frequency; probes are not
//! filtered. Ticks between samples only write to the past.

use super::Op;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// Filters every sound channel. `layout.lowpass` holds the first half of the n coefficients up to the middle one.
pub fn lowpass<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some((middle, sides)) = layout.out.lowpass.split_last() else { return };
    let n = 2 * sides.len() + 1;
    let at = (s.tick % n as u64) as usize;
    for (out, past) in s.output[..op.n].iter_mut().zip(s.ports.lowpass.chunks_exact_mut(2 * n)) {
        store(past, at, n, *out);
        let window = &past[at + 1..][..n];
        let mut y = *middle * window[sides.len()];
        for ((h, a), b) in sides.iter().zip(window).zip(window.iter().rev()) {
            y += *h * (*a + *b);
        }
        *out = y.outer();
    }
}

/// Stores the value of every sound channel at a tick between samples.
pub fn remember<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let Some((_, sides)) = layout.out.lowpass.split_last() else { return };
    let n = 2 * sides.len() + 1;
    let at = (s.tick % n as u64) as usize;
    for (out, past) in s.output[..op.n].iter().zip(s.ports.lowpass.chunks_exact_mut(2 * n)) {
        store(past, at, n, *out);
    }
}

fn store<R: Real>(past: &mut [R], at: usize, n: usize, v: R::Outer) {
    past[at] = R::inner(v);
    past[at + n] = past[at];
}
