//! Sweeps over links that are solved together, if one is a curve: each link in turn is solved against the present pushes of all others.
//!
//! This is the Gauss-Seidel method with one Newton step a link (docs/numerics.md §3.3). For link l, with the push h(s),
//! its slope h′ and the mobility c of the ends, and with s the change of penetration assumed so far:
//! ```text
//! r = s* − Σ W N + c (N − h(s)) − s        s ← s + r / (1 + c h′)        N ← h(s) + h′ r / (1 + c h′)
//! ```
//! Here s* is the change over two ticks that all other forces would cause, and W the motion at this link per push of each
//! link. In code: s = `at`, s* = `free`, N = `p`, c = `own`, h′ = `rise`, c h′ = `steep`, Σ W N = `by_all`.
//!
//! The system has one solution (`cluster.rs`), and each sweep brings soft links nearer to it, by a factor of about
//! kT²/m. The sweeps give up if a link is stiff (c h′ > 1), if a contact that may only push would pull, if they converge
//! slowly, or after [`MAX_SWEEPS`]. Then `cluster.rs` solves.

use super::cluster::push;
use super::system::{Response, places};
use crate::numeric::{Precision, Real};
use crate::state::active_contacts::{ActiveContact, Part, Port};

/// Maximum number of sweeps per tick.
const MAX_SWEEPS: usize = 16;
/// From the third sweep on, each change must be at most this factor times the one before.
const LARGEST_RATIO: f64 = 0.25;

/// Solves for push `p` and change of penetration `at` of each link, and sets `y`, which linear links use. Returns false
/// if it gave up.
pub(super) fn swept<R: Real, const MODES: bool>(all: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) -> bool {
    let last = R::of(if matches!(R::PRECISION, Precision::Single) { 3e-7 } else { 4e-16 });
    for t in &mut *all {
        (t.p, t.at) = (R::ZERO, t.went);
    }
    let (mut before, mut solved) = (R::INFINITY, false);
    for sweep in 0..MAX_SWEEPS {
        let acting = all.iter_mut().filter(|t| sweep == 0 || t.part == Part::Acts || t.p != R::ZERO);
        let worst = acting.map(|t| visit(t, to, sweep == 0)).fold(R::ZERO, R::max);
        let falls = worst <= R::of(LARGEST_RATIO) * before;
        // the next change would be smaller by the same factor
        solved = worst <= last || falls && sweep > 0 && worst * worst <= last * before;
        if solved && sweep > 0 {
            // others may have pushed a waiting contact meanwhile
            for t in all.iter_mut().filter(|t| t.part == Part::Waits && t.p == R::ZERO) {
                solved &= visit(t, to, true) == R::ZERO;
            }
        }
        // in this order, so that NaN ends the sweeps
        if solved || !(falls || sweep < 2) || worst == R::INFINITY {
            break;
        }
        before = worst;
    }
    for t in &mut *all {
        solved &= t.curve.is_some() || !t.clip || t.p >= R::ZERO;
        t.y = t.stiff * t.at;
        places(t, |a, b, _| (to.push[a], to.push[b]) = (R::ZERO, R::ZERO));
    }
    solved
}

/// Solves one link against the present pushes of all others. With `first`, or for a contact that waits, it
/// also computes the scale of the motion.
///
/// Returns the magnitude of the change of s relative to that scale, or infinity for a stiff link or a quadripole. During
/// the sweeps `to.push` holds the displacements \[m\] that all pushes cause.
#[inline(always)]
fn visit<R: Real, const MODES: bool>(t: &mut ActiveContact<R>, to: &mut Response<R, MODES>, first: bool) -> R {
    if t.onto.is_some() {
        return R::INFINITY;
    }
    let Port { ends, axes, g } = t.port;
    let [a, b] = ends.map(|m| m as usize);
    let Response { layout, mobility, push: moved, .. } = to;
    let mut by_all = g[0] * (moved[b] - moved[a]);
    for k in 1..axes {
        by_all += g[k] * (moved[b + k] - moved[a + k]);
    }
    if t.part == Part::Waits && t.p == R::ZERO {
        t.at = t.free - by_all;
        if t.from + t.at <= R::ZERO {
            return R::ZERO;
        }
    }
    let [force, rise] = match t.curve {
        Some(curve) => push(t, curve, &layout.tables),
        None => [t.bias + t.stiff * t.at, t.stiff],
    };
    // where the force falls, only its value is used
    let rise = rise.max(R::ZERO);
    let (steep, to_depth) = (t.own * rise, t.from + t.at);
    // in the tick in which a contact closes or opens, the slope may be small and the contact stiff
    let crosses = (t.from > R::ZERO) != (to_depth > R::ZERO);
    if steep > R::of(1.0) || crosses && t.own * force.abs() > t.from.max(to_depth) {
        return R::INFINITY;
    }
    if first || t.part == Part::Waits {
        // without a division in each sweep
        t.r = R::of(1.0) / t.free.abs().max(t.went.abs()).max(t.from.abs()).max(R::of(f64::MIN_POSITIVE));
    }
    let change = (t.free - by_all + t.own * (t.p - force) - t.at) / (R::of(1.0) + steep);
    let more = force + rise * change - t.p;
    t.at += change;
    t.p += more;
    for k in 0..axes {
        moved[a + k] -= g[k] * mobility[a + k] * more;
        moved[b + k] += g[k] * mobility[b + k] * more;
    }
    change.abs() * t.r
}
