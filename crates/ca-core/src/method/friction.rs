//! Friction at the speed in the middle of the tick, which only resists at any steepness (docs/numerics.md §3.5).
//!
//! The explicit law uses the speed of the tick before. If its curve is steep against the masses, ends that should stick
//! ring instead. Here the force is F = λu with the centred motion u = (e₊ − e₋)/2 and λ ≥ 0. Its work over the tick,
//! λu², is heat for any λ. Let r be the value of u by all other forces, and c half the mobility of the two ends: u = r
//! − cF = r/(1 + cλ), without iteration once λ is known. Both methods use λ = F(v)/v:
//! - **secant** takes v from the tick before: first order, and correct at any steepness.
//! - **newton** takes v = u, the root of u + cF(u) = r between 0 and r: second order. If the curve is steeper than 4
//!   against the masses, the secant replaces it. There the bell curve soon has several roots, and the motion d of
//!   sticking ends would change sign at every tick. With the secant this decays slowly: after n ticks fT/4mn remains.
//!
//! Both methods end with the same step, so an iteration that has not converged costs accuracy and no energy. Where
//! links share a MAT, and in space, they form one linear system in the motion, which `together.rs` solves with the
//! contacts. The λ of the secant are viscosities in it. A table that adds energy is limited to its resisting part.

use super::newton::root;
use super::system::{LinearPush, join, reach};
use super::{free_motion, mobility};
use crate::law::{Bound, Phi};
use crate::numeric::{Real, Table};
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure, Radial};
use crate::op::{Cheaper, Coupled, LoadFns};
use crate::op::{Energies, Form, Kernel, Law, LawFns, Op, SolveStage, Together};
use crate::state::State;

/// Newton's method runs while slope times T²/m of both ends is below this; the root is unique up to 4.48 (§3.5).
pub const STEEPEST: f64 = 4.0;

/// A law of speed alone. F(w) has the sign of w, the change of elongation per tick.
pub trait Curve<const C: usize>: Phi<C, 0> {
    /// Returns F(w)/w \[N per m/tick\], or the slope at rest for w = 0.
    fn chord<R: Real>(c: &[R; C], tables: &[Table<R>], w: R) -> R;

    /// Returns the steepest slope \[N per m/tick\].
    fn steep<R: Real>(c: &[f64; C], tables: &[Table<R>]) -> f64;

    /// Returns the slope at w \[N per m/tick\].
    fn slope<R: Real>(c: &[R; C], tables: &[Table<R>], w: R) -> R;
}

/// Makes a law by the secant or by `NEWTON`. If it cannot act alone, `together` runs. Memory: heat of the tick \[J\].
pub const fn alone<P: Curve<C> + 'static, const C: usize, const NEWTON: bool>(
    code: &'static str,
    curve: Law,
    together: &'static Law,
) -> Law {
    Law {
        code,
        mem: 1,
        at_load: LoadFns { bound: bound::<P, C>, ..curve.at_load },
        stage: SolveStage::Single(Together::same(together)),
        cheaper: Cheaper::NONE,
        fns: alone_fns::<f64, P, C, NEWTON>(curve.fns),
        ..curve
    }
}

/// Makes its functions from the functions of the curve.
pub const fn alone_fns<R: Real, P: Curve<C> + 'static, const C: usize, const NEWTON: bool>(
    curve: LawFns<R>,
) -> LawFns<R> {
    LawFns {
        start: |_, _, mem| mem.fill(R::ZERO),
        energies: Energies::kept(curve.energies.stored, |_, mem, _, _| mem[0]),
        kernel: |_| rub::<R, P, C, NEWTON>,
        ..curve
    }
}

/// Makes the law of a curve by the secant, solved together with contacts. Memory: unused, heat of the tick \[J\].
pub const fn together<P: Curve<C> + 'static, const C: usize>(code: &'static str, curve: Law) -> Law {
    Law {
        code,
        mem: 2,
        at_load: LoadFns { bound: bound::<P, C>, ..curve.at_load },
        stage: SolveStage::Coupled(Coupled { curve: false, at_modes: None }),
        cheaper: Cheaper::NONE,
        fns: together_fns::<f64, P, C>(curve.fns),
        ..curve
    }
}

/// Makes its functions from the functions of the curve.
pub const fn together_fns<R: Real, P: Curve<C> + 'static, const C: usize>(curve: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |_, _, mem| mem.fill(R::ZERO),
        energies: Energies::kept(curve.energies.stored, |_, mem, _, _| mem[1]),
        kernel: kernel::<R, P, C>,
        ..curve
    }
}

/// Returns the bound of the curve, marked as passive.
fn bound<P: Curve<C>, const C: usize>(c: &[f64], tables: &[Table]) -> Bound {
    Bound { active: false, ..c.first_chunk().map_or(Bound::default(), |c| P::bound(c, tables)) }
}

fn kernel<R: Real, P: Curve<C> + 'static, const C: usize>(form: Form) -> Kernel<R> {
    match form.measure {
        MeasureKind::Line => gather::<R, P, Line, C>,
        MeasureKind::Along => gather::<R, P, Along, C>,
        MeasureKind::Radial => gather::<R, P, Radial, C>,
    }
}

/// Applies the links of `op`, one by one.
fn rub<R: Real, P: Curve<C>, const C: usize, const NEWTON: bool>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let tables = &layout.tables;
    for i in 0..op.n {
        let coef = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        let [p, q] = layout.links.ends[op.first + i].map(|m| m as usize);
        let w = s.d[q] - s.d[p];
        let r = R::of(0.5) * (w + (free_motion(layout, s, q) - free_motion(layout, s, p)));
        let c = R::of(0.5) * (mobility(layout, s, p) + mobility(layout, s, q));
        let mut steep = P::chord(&coef, tables, w).max(R::ZERO);
        if NEWTON && R::of(2.0) * c * R::of(P::steep(&coef.map(R::wide), tables)) < R::of(STEEPEST) {
            let u = root(r / (R::of(1.0) + c * steep), [r.min(R::ZERO), r.max(R::ZERO)], R::ZERO, |u| {
                let force = P::force(&coef, &mut [], tables, R::ZERO, u);
                (u + c * force - r, R::of(1.0) + c * P::slope(&coef, tables, u))
            });
            steep = P::chord(&coef, tables, u).max(R::ZERO);
        }
        let moved = r / (R::of(1.0) + c * steep);
        let force = steep * moved;
        s.f[p] += force;
        s.f[q] -= force;
        s.links.mem[op.mem + i] = force * moved;
        if op.form.tap {
            s.links.tap[op.tap + i] = force;
        }
    }
}

/// Collects the links of `op`.
fn gather<R: Real, P: Curve<C>, G: Measure, const C: usize>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let coef = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        let ends = layout.links.ends[op.first + i].map(|m| m as usize);
        let at = if G::SPACE { layout.links.reach[op.ports.reach + i] } else { [R::ZERO; 4] };
        let measured = G::measure(&s.x, &s.d, ends, &at);
        let z = P::chord(&coef, &layout.tables, measured.w).max(R::ZERO);
        s.links.mem[op.mem + 2 * i + 1] = R::ZERO;
        if op.form.tap {
            s.links.tap[op.tap + i] = R::ZERO;
        }
        let link = reach::<R, G>(op, layout, s, i, R::of(1.0), measured.gradient());
        let none = R::ZERO;
        join(s, op.mem + 2 * i, link, LinearPush { clip: false, open: false, gamma: none, psi: none, z });
    }
}
