//! Friction against the speed in the middle of the tick, so that it only resists however steep its curve
//! (docs/numerics.md §3.5).
//!
//! The explicit law takes the speed of the tick before; where its curve is steep against the masses, what should stick
//! rings instead. Here the force is F = λu with u = (e₊ − e₋)/2, the centred motion, and λ ≥ 0: its work over the tick
//! is λu², heat and never a gift, whatever λ is. With r what all other forces would make of u, and c half the mobility of
//! the two ends, u = r − cF = r/(1 + cλ): nothing is iterated once λ is known. Both methods take λ = F(v)/v, of
//! - **secant**: v of the tick before. First order, and right at any steepness;
//! - **newton**: v = u itself, the root of u + cF(u) = r between 0 and r. Second order. Where the curve is steeper than 4
//!   against the masses the secant serves: there the bell curve soon has more roots than one, and what sticks to u = 0
//!   would leave the motion itself, d, changing its sign at every tick. By the secant that dies out, if slowly: after n
//!   ticks fT/4mn is left of it.
//!
//! In both the last step is the same, so an iteration that has not quite arrived costs accuracy and no energy. Where
//! the place is shared, and in space, all is one linear system in the motion, which `together.rs` beside this solves with
//! the contacts: the λ of the secant are viscosities there. A table that drives is cut to what resists.

use super::newton::root;
use super::system::{join, reach};
use super::{free_motion, mobility};
use crate::law::{Bound, Phi};
use crate::numeric::{Real, Table};
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure, Radial};
use crate::op::{Cheaper, LoadFns};
use crate::op::{Energies, Form, Kernel, Law, LawFns, Op, SolveStage, Together};
use crate::state::State;
use crate::state::active_contacts::ActiveContact;

/// Newton while the steepest slope times T²/m of both ends is below this; the root of the bell curve is the only one up
/// to 4.48 (docs/numerics.md §3.5).
pub const STEEPEST: f64 = 4.0;

/// A law of speed alone, F(w) of the sign of w, w the change of elongation per tick.
pub trait Curve<const C: usize>: Phi<C, 0> {
    /// F(w)/w \[N per m/tick\]; the slope at rest for w = 0.
    fn chord<R: Real>(c: &[R; C], tables: &[Table<R>], w: R) -> R;

    /// The steepest slope \[N per m/tick\].
    fn steep<R: Real>(c: &[f64; C], tables: &[Table<R>]) -> f64;

    /// The slope at w \[N per m/tick\].
    fn slope<R: Real>(c: &[R; C], tables: &[Table<R>], w: R) -> R;
}

/// The curve by secant or `NEWTON`; where it may not act alone, `together` runs. Memory: heat of the tick \[J\].
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

/// Its functions, made of the functions of the curve.
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

/// The curve by secant, solved together with all that touches. Memory: nothing, heat of the tick \[J\].
pub const fn together<P: Curve<C> + 'static, const C: usize>(code: &'static str, curve: Law) -> Law {
    Law {
        code,
        mem: 2,
        at_load: LoadFns { bound: bound::<P, C>, ..curve.at_load },
        stage: SolveStage::Coupled(None),
        cheaper: Cheaper::NONE,
        fns: together_fns::<f64, P, C>(curve.fns),
        ..curve
    }
}

/// Its functions, made of the functions of the curve.
pub const fn together_fns<R: Real, P: Curve<C> + 'static, const C: usize>(curve: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |_, _, mem| mem.fill(R::ZERO),
        energies: Energies::kept(curve.energies.stored, |_, mem, _, _| mem[1]),
        kernel: kernel::<R, P, C>,
        ..curve
    }
}

/// That of the curve, of which nothing drives.
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
        join(s, ActiveContact { z, ..link });
    }
}
