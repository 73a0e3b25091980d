//! Coulomb friction as a set-valued law: sticking ends are held by any force up to the largest (docs/numerics.md §3.5).
//!
//! A curve creeps where ends should stick, however steep it is. Here the force is solved for. Let r be the relative
//! motion that all other forces cause in this tick, and c the mobility of both ends; F = r/c cancels the motion. If |F|
//! is at most the static force (when stuck before) or the sliding force (when sliding), the ends stick. Otherwise they
//! slide against the sliding force. If the motion reverses by itself within a tick, the force is zero in that tick.
//!
//! So F·(w + w₊)/2 ≥ 0 always: it is heat, and zero while sticking. The moments of sticking and slipping are of first
//! order. On a mass with several such links, or with contacts that conserve energy, the curve runs instead, and its
//! creep is reported.

use super::{free_motion, mobility};
use crate::law::Bound;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::{Cheaper, LoadFns};
use crate::op::{Energies, Law, LawFns, Op, SolveStage, Together};
use crate::state::State;

/// Numbers of memory: 1 while sticking, and the heat of the tick \[J\].
pub const MEM: usize = 2;

/// Makes Coulomb friction with f and fd as first coefficients. If it cannot act alone, `together` runs.
pub const fn alone(code: &'static str, curve: Law, together: &'static Law) -> Law {
    Law {
        code,
        mem: MEM,
        at_load: LoadFns { bound: |_, _| Bound { curve: true, ..Bound::default() }, ..curve.at_load },
        stage: SolveStage::Single(Together::same(together)),
        cheaper: Cheaper::NONE,
        fns: fns(curve.fns),
        ..curve
    }
}

/// Makes its functions from the functions of the curve.
pub const fn fns<R: Real>(curve: LawFns<R>) -> LawFns<R> {
    LawFns {
        // ends at rest at load stick
        start: |_, [_, w], mem| {
            mem[0] = R::of(if w == R::ZERO { 1.0 } else { 0.0 });
            mem[1] = R::ZERO;
        },
        energies: Energies::kept(curve.energies.stored, |_, mem, _, _| mem[1]),
        kernel: |_| rub,
        ..curve
    }
}

fn rub<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let [f, fd]: [R; 2] = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        let [p, q] = layout.links.ends[op.first + i].map(|m| m as usize);
        let mem = op.mem + MEM * i;
        let stuck = s.links.mem[mem] != R::ZERO;
        // the motion of stuck ends is only rounding
        let w = if stuck { R::ZERO } else { s.d[q] - s.d[p] };
        let r = free_motion(layout, s, q) - free_motion(layout, s, p);
        let c = mobility(layout, s, p) + mobility(layout, s, q);
        let (force, sticks) = hold([f, fd], [w, r], c, stuck);
        s.f[p] += force;
        s.f[q] -= force;
        s.links.mem[mem] = if sticks { R::of(1.0) } else { R::ZERO };
        s.links.mem[mem + 1] = force * R::of(0.5) * (w + (r - c * force));
        if op.form.tap {
            s.links.tap[op.tap + i] = force;
        }
    }
}

/// Returns the force \[N\] and whether the link sticks in this tick.
///
/// The arguments are the largest forces of sticking and of sliding, the relative motion of the last tick and that by
/// all other forces \[m/tick\], the mobility of all ends \[m/N\], and whether it stuck before.
pub fn hold<R: Real>([f, fd]: [R; 2], [w, r]: [R; 2], c: R, stuck: bool) -> (R, bool) {
    let most = if stuck { f } else { fd };
    if w * r < R::ZERO || (c <= R::ZERO && r == R::ZERO) {
        return (R::ZERO, stuck && c <= R::ZERO);
    }
    // between two ports a force can hold nothing
    let needed = if c > R::ZERO { r / c } else { R::INFINITY.copysign(r) };
    if needed.abs() <= most { (needed, true) } else { (fd.copysign(r), false) }
}

/// Returns the sliding force. With shared masses it is a curve with a creep of `v0`.
#[inline(always)]
pub fn sliding<R: Real>([f, fd, v0]: [R; 3], w: R) -> R {
    if w.abs() <= v0 { f * (w / v0) } else { fd.copysign(w) }
}

/// Returns the same force over the motion.
#[inline(always)]
pub fn chord<R: Real>([f, fd, v0]: [R; 3], w: R) -> R {
    if w.abs() <= v0 { f / v0 } else { fd / w.abs() }
}
