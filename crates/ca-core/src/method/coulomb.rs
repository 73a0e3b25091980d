//! Coulomb's friction as a set-valued law: what sticks stands still, and any force up to the largest holds it
//! (docs/numerics.md §3.5).
//!
//! A curve, however steep, creeps where it should stick. Here the force is asked for instead: with r what all other forces make
//! of the relative motion in this tick, and c the mobility of both ends, F = r/c leaves none of it. If that is no more than the
//! static force of what stuck, or the sliding force of what slid, it sticks; else it slides on against the sliding force. Where
//! the motion turns round by itself within a tick, there is no force in that tick. So F·(w + w₊)/2 ≥ 0 always: heat, never a
//! gift, and of what sticks none at all. Of first order in the moments of sticking and slipping. Against a solver for all links
//! at once: where a mass has several of them, or contacts that keep energy, the curve takes over, with a creep that is said.

use super::{free_motion, mobility};
use crate::law::Bound;
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::{Cheaper, LoadFns};
use crate::op::{Energies, Law, LawFns, Op, SolveStage, Together};
use crate::state::State;

/// What a link remembers: 1 where it sticks, and the heat of the tick \[J\].
pub const MEM: usize = 2;

/// Coulomb's friction alone, whose first coefficients are f and fd; where it may not act alone, `together` runs.
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

/// Its functions, made of the functions of the curve.
pub const fn fns<R: Real>(curve: LawFns<R>) -> LawFns<R> {
    LawFns {
        // what stands still at load sticks
        start: |_, [_, w], mem| {
            mem[0] = R::of(if w == R::ZERO { 1.0 } else { 0.0 });
            mem[1] = R::ZERO;
        },
        energies: Energies::kept(curve.energies.stored, |_, mem, _, _| mem[1]),
        kernel: |_| rub,
        ..curve
    }
}

/// Applies the links of `op`, one by one.
fn rub<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let [f, fd]: [R; 2] = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        let [p, q] = layout.links.ends[op.first + i].map(|m| m as usize);
        let mem = op.mem + MEM * i;
        let stuck = s.links.mem[mem] != R::ZERO;
        // what stuck has no motion but that of rounding
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

/// The force \[N\], and whether it sticks in this tick: of the largest forces of sticking and of sliding, the relative motion of the last
/// tick and that which all other forces make \[m/tick\], the mobility of all ends \[m/N\], and whether it stuck before.
pub fn hold<R: Real>([f, fd]: [R; 2], [w, r]: [R; 2], c: R, stuck: bool) -> (R, bool) {
    let most = if stuck { f } else { fd };
    if w * r < R::ZERO || (c <= R::ZERO && r == R::ZERO) {
        return (R::ZERO, stuck && c <= R::ZERO);
    }
    // between two ports nothing can be held
    let needed = if c > R::ZERO { r / c } else { R::INFINITY.copysign(r) };
    if needed.abs() <= most { (needed, true) } else { (fd.copysign(r), false) }
}

/// The force of what slides, and the curve where links share a mass: a creep of `v0`.
#[inline(always)]
pub fn sliding<R: Real>([f, fd, v0]: [R; 3], w: R) -> R {
    if w.abs() <= v0 { f * (w / v0) } else { fd.copysign(w) }
}

/// The same over the motion.
#[inline(always)]
pub fn chord<R: Real>([f, fd, v0]: [R; 3], w: R) -> R {
    if w.abs() <= v0 { f / v0 } else { fd / w.abs() }
}
