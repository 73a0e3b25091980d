//! Newton's method for the root of a rising function between two bounds, with a bounded number of steps.
//!
//! It takes Newton's step if that stays between the bounds, and bisects otherwise, as in every second step after many.
//! A kink or a flat stretch thus costs steps but never the root, which stays between the bounds.

use crate::numeric::{Precision, Real};

/// Maximum number of steps. From [`HALVED`] on every second step bisects, and these bisections alone exhaust the 53
/// bits of a double. Newton's steps could alternate between two kinks forever.
const STEPS: usize = 128;
const HALVED: usize = 16;
/// Relative size of a step that is the last: the next would be its square.
const NEAR: f64 = 1e-9;

/// Returns the root of a function between `low` and `high`, starting at `s`. `at` gives value and slope. The tolerance
/// is relative to `scale` or to the root itself, whichever is larger.
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

/// Adds to a root its derivatives by what the function depends on: the derivatives of the value there over its slope.
/// The derivatives of the steps differ from these by as much as the last step.
#[inline(always)]
fn derived<R: Real>(root: R, at: impl Fn(R) -> (R, R)) -> R {
    if !matches!(R::PRECISION, Precision::Dual) {
        return root;
    }
    let root: R = R::of(root.wide());
    let (value, slope) = at(root);
    if slope == R::ZERO { root } else { root - (value - R::of(value.wide())) / slope }
}
