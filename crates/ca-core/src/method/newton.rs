//! Newton: the root of a rising function between two bounds, in a number of steps that has an end.
//!
//! Decides for Newton's step where it stays between the bounds and halving where it does not, and for every second step once there
//! were many, so that a kink or a flat place costs steps and never the root. The root lies between the bounds whatever the function is.

use crate::numeric::{Precision, Real};

/// More is never taken. From [`HALVED`] on every second step is a halving, and these alone leave nothing of a double's 53 bits:
/// between two kinks Newton's steps may go to and fro for ever.
const STEPS: usize = 128;
const HALVED: usize = 16;
/// A step this small, as part of the place, is the last: the next would be its square.
const NEAR: f64 = 1e-9;

/// The root of a function from `s` on between `low` and `high`; `at` gives value and slope. Changes are small beside
/// `scale` or the place itself.
#[inline]
pub fn root<R: Real>(mut s: R, [mut low, mut high]: [R; 2], scale: R, at: impl Fn(R) -> (R, R)) -> R {
    for step in 0..STEPS {
        let (value, slope) = at(s);
        let to = s - value / slope;
        if (to - s).abs() <= R::of(NEAR) * scale.max(s.abs()) {
            return derived(to.max(low).min(high), at);
        }
        (low, high) = if value > R::ZERO { (low, s) } else { (s, high) };
        let halves = step >= HALVED && step % 2 == 0;
        s = if low < to && to < high && !halves { to } else { R::of(0.5) * (low + high) };
    }
    derived(s, at)
}

/// A root with its derivatives by what the function depends on: those of its value there, over its slope. The steps that led
/// there have others, which are as near to them as the last step was small.
#[inline(always)]
fn derived<R: Real>(root: R, at: impl Fn(R) -> (R, R)) -> R {
    if !matches!(R::PRECISION, Precision::Dual) {
        return root;
    }
    let root: R = R::of(root.wide());
    let (value, slope) = at(root);
    if slope == R::ZERO { root } else { root - (value - R::of(value.wide())) / slope }
}
