//! Discrete gradients solved together, for contacts on a line that share masses (docs/numerics.md §3.3).
//!
//! Each contact pushes with the slope of its potential between the tick before and the tick after, as in
//! [`super::gradient`], but the penetration after the tick depends on all contacts:
//! ```text
//! N_l = h_l(s_l)        s = s* − W N        h(s) = (U(a + s) − U(a)) / s + (z/2) s
//! ```
//! Here s is the change of penetration over two ticks, s* the change by all other forces, a the penetration before, and
//! W = T² G M⁻¹ Gᵀ. A rising force makes h rise. So the solution minimises a strictly convex function, and there is
//! one.
//!
//! Newton's method with a line search finds it. s₊ is the change that the next iteration finds. With the tangent
//! N ≈ h(s) + h′(s) (s₊ − s) = b + h′(s) s₊ every iteration is the linear system of `system.rs`. In code, b is `bias`
//! and h′ is `stiff`. This system therefore also takes the contacts in space and the friction that share masses with
//! these contacts. If h′ = 0, the contact has the constant push `bias`.
//!
//! The stored energy is U of the true penetration, so it does not drift, and the energy balances at any stiffness. With
//! `sticky = false` a pull is left out: h is 0 there, and the energy that U loses is heat.

use super::spring::{Contact, Spring};
use super::system::{Response, conjugate, enter, gathered, reach, respond};
use crate::numeric::{Precision, Real, Table};
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure, Radial};
use crate::op::{Coupled, Energies, Form, Kernel, Law, LawFns, Op, SolveStage};
use crate::state::State;
use crate::state::active_contacts::{ActiveContact, Curve, Part};
use core::marker::PhantomData;

/// Maximum number of Newton steps per tick; four are usual.
const MAX_STEPS: usize = 100;
/// Number of steps that are never shortened. After a contact is left out, the next two are not shortened either.
const FULL_STEPS: usize = 4;
/// Maximum number of times that one step is shortened.
const MAX_SHORTENINGS: usize = 20;

/// Tolerances: relative changes of motion at which the result of a step is accepted. The change is the largest of all
/// contacts.
struct Near<R> {
    /// accept at this change
    last: R,
    /// accept at this change if it is more than 3/4 of the one before: rounding has been reached
    rounded: R,
    /// once steps may be shortened, accept at this change if it is more than half of the smallest so far
    stands: R,
    /// as `stands`, with the change relative to the largest motion; either of the two is enough
    of_all: R,
}

fn near<R: Real>() -> Near<R> {
    let single = matches!(R::PRECISION, Precision::Single);
    let [last, rounded, stands, of_all] = if single { [3e-7, 1e-4, 1e-3, 1e-5] } else { [4e-16, 1e-11, 1e-9, 1e-13] };
    Near { last: R::of(last), rounded: R::of(rounded), stands: R::of(stands), of_all: R::of(of_all) }
}

/// Makes a one-sided spring with this method; `at_modes` runs at modal masses. Memory: heat of the tick \[J\].
pub const fn law<S: Spring<f64> + 'static>(spring: Law, at_modes: &'static Law) -> Law {
    Law {
        mem: 1,
        stage: SolveStage::Coupled(Coupled { curve: true, at_modes: Some(at_modes) }),
        fns: fns::<f64, S>(spring.fns),
        ..spring
    }
}

/// Makes its functions from the functions of the spring.
pub const fn fns<R: Real, S: Spring<R> + 'static>(spring: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |_, _, mem| mem.fill(R::ZERO),
        energies: Energies::kept(spring.energies.stored, |_, mem, _, _| mem[0]),
        kernel: kernel::<R, S>,
        ..spring
    }
}

fn kernel<R: Real, S: Spring<R> + 'static>(form: Form) -> Kernel<R> {
    match form.measure {
        MeasureKind::Line => gather::<R, S, Line>,
        MeasureKind::Along => gather::<R, S, Along>,
        MeasureKind::Radial => gather::<R, S, Radial>,
    }
}

/// Collects the contacts of `op`, also those that touch nothing, since another contact may push them.
fn gather<R: Real, S: Spring<R> + 'static, G: Measure>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let contact = Contact::<R, S>::read(s, op.coef, op.n, i);
        let ends = layout.links.ends[op.first + i].map(|m| m as usize);
        let at = if G::SPACE { layout.links.reach[op.ports.reach + i] } else { [R::ZERO; 4] };
        s.links.mem[op.mem + i] = R::ZERO;
        if op.form.tap {
            s.links.tap[op.tap + i] = R::ZERO;
        }
        let measured = G::measure(&s.x, &s.d, ends, &at);
        let now = contact.penetration(measured.e + layout.links.e0[op.first + i]);
        let from = now + contact.side * measured.w;
        let link = reach::<R, G>(op, layout, s, i, contact.side, measured.gradient());
        let z = if now > R::ZERO { contact.spring.viscosity(contact.k, now) } else { R::ZERO };
        let touches = from + link.free > R::ZERO || from > R::ZERO || z > R::ZERO;
        let part = if touches { Part::Acts } else { Part::Waits };
        let coef = core::array::from_fn(|k| s.coef[op.coef + k * op.n + i]);
        if let Some(t) = enter(s, op.mem + i, link) {
            (t.curve, t.part, t.clip, t.coef) = (Some(OfSpring::<R, S>::CURVE), part, contact.clip, coef);
            (t.from, t.z, t.went) = (from, z, R::of(2.0) * (now - from));
        }
    }
}

struct OfSpring<R, S>(PhantomData<(R, S)>);

impl<R: Real, S: Spring<R> + 'static> OfSpring<R, S> {
    const CURVE: &'static Curve<R> = &Curve {
        push: |coef, _, from, change| Contact::<R, S>::of(coef).between(from, change),
        released: |coef, _, from, change| {
            let contact = Contact::<R, S>::of(coef);
            contact.potential(from) - contact.potential(from + change)
        },
        begin: |t| {
            if t.part == Part::Waits { t.free } else { Contact::<R, S>::of(&t.coef).alone(t.from, t.free, t.own, t.z) }
        },
    };
}

/// Returns the push of a curve with its viscosity, and its slope, at the assumed change of penetration.
pub(super) fn push<R: Real>(t: &ActiveContact<R>, curve: &Curve<R>, tables: &[Table<R>]) -> [R; 2] {
    let [push, slope] = (curve.push)(&t.coef, tables, t.from, t.at);
    let half = R::of(0.5) * t.z;
    let [push, slope] = [push + half * t.at, slope + half];
    if t.clip && push < R::ZERO { [R::ZERO; 2] } else { [push, slope] }
}

/// Solves for the push `p` and the change of penetration `at` of all contacts. Returns false at the iteration limit. If
/// they are `solved` already, finds their derivatives.
pub(super) fn newton<R: Real, const MODES: bool>(
    all: &mut [ActiveContact<R>],
    to: &mut Response<R, MODES>,
    mut solved: bool,
) -> bool {
    let (mut before, mut least) = (R::INFINITY, R::INFINITY);
    for t in &mut *all {
        t.found = [t.p, t.at, t.y];
        if let (false, Some(curve)) = (solved, t.curve) {
            t.at = (curve.begin)(t);
        }
    }
    let (near, mut searched) = (near::<R>(), FULL_STEPS);
    for step in 0..MAX_STEPS {
        let full = step < searched || solved || !shortened(all, &to.layout.tables);
        for t in &mut *all {
            if let Some(curve) = t.curve {
                let [push, slope] = push(t, curve, &to.layout.tables);
                t.last = [t.at, t.p, push - t.p];
                // where the force falls, only its value is used
                t.stiff = slope.max(R::ZERO);
                t.bias = push - t.stiff * t.at;
            } else {
                t.last = [t.at, t.p, R::ZERO];
                let [bias, stiff] = [t.gamma * t.psi, R::of(0.25) * t.gamma * t.gamma + R::of(0.5) * t.z];
                (t.bias, t.stiff) = if t.part == Part::LeftOut { (R::ZERO, R::ZERO) } else { (bias, stiff) };
            }
            if t.stiff > R::ZERO {
                t.diag = t.own + R::of(1.0) / t.stiff;
            }
        }
        let acting = gathered(all, |t| t.stiff > R::ZERO);
        // without slope the push is the bias
        let pushing = acting + gathered(&mut all[acting..], |t| t.bias != R::ZERO);
        conjugate(&mut all[..pushing], acting, to);
        for (i, t) in all.iter_mut().enumerate() {
            t.p = if i < acting { t.bias + t.y } else { t.bias };
        }
        respond(all, to);
        let (mut again, mut worst, mut moves, mut far) = (false, R::ZERO, R::ZERO, R::ZERO);
        for (i, t) in all.iter_mut().enumerate() {
            // stiff: the difference free − q cancels, so the motion follows from the push. Soft: the push has few
            // digits, so the motion is that difference
            let stiff = i < acting && t.stiff * t.own > R::of(1.0);
            let moved = if stiff { t.y / t.stiff } else { t.free - t.q };
            if t.curve.is_none() {
                // a contact that would pull is left out for this tick
                if t.clip && t.p < R::ZERO && !solved {
                    (t.part, again) = (Part::LeftOut, true);
                }
                t.at = moved;
                continue;
            }
            let scale = t.free.abs().max(moved.abs()).max(t.from.abs());
            worst = worst.max((moved - t.at).abs() / scale.max(R::of(f64::MIN_POSITIVE)));
            (moves, far) = (moves.max((moved - t.at).abs()), far.max(scale));
            t.at = moved;
        }
        if solved {
            // one more step has brought the derivatives; values stay as found before
            let keep = |found: R, now: R| R::of(found.wide()) + (now - R::of(now.wide()));
            for t in &mut *all {
                let [push, moved, y] = t.found;
                (t.p, t.at, t.y) = (keep(push, t.p), keep(moved, t.at), keep(y, t.y));
            }
            return true;
        }
        if again {
            // the step has begun with the push of a contact that is now left out, so the function has changed
            searched = searched.max(step + 3);
        }
        let hardly_smaller = full && worst <= near.rounded && worst > R::of(0.75) * before;
        let little = worst <= near.stands || moves <= near.of_all * far;
        let stands = step > searched && little && worst > R::of(0.5) * least;
        solved = !again && (worst <= near.last || hardly_smaller || stands);
        (before, least) = (worst, least.min(worst));
        if solved {
            if !matches!(R::PRECISION, Precision::Dual) {
                return true;
            }
            for t in &mut *all {
                t.found = [t.p, t.at, t.y];
            }
        }
    }
    solved
}

/// Shortens the last step while the slope of the convex function along it, Σ (h − N) Δs, is above half of its magnitude
/// at the start of the step. Returns true if it changed the step.
fn shortened<R: Real>(all: &mut [ActiveContact<R>], tables: &[Table<R>]) -> bool {
    let curves = |all: &[ActiveContact<R>], excess: &dyn Fn(&ActiveContact<R>, &Curve<R>) -> R| -> R {
        all.iter().filter_map(|t| Some(excess(t, t.curve?) * (t.at - t.last[0]))).sum()
    };
    for tries in 0..MAX_SHORTENINGS {
        let before = curves(all, &|t, _| t.last[2]).abs();
        let now = curves(all, &|t, curve| push(t, curve, tables)[0] - t.p);
        if now.wide().is_nan() || now <= R::of(0.5) * before {
            return tries > 0;
        }
        let share = (before / (before + now)).max(R::of(0.1)).min(R::of(0.5));
        for t in &mut *all {
            t.at = t.last[0] + share * (t.at - t.last[0]);
            t.p = t.last[1] + share * (t.p - t.last[1]);
        }
    }
    true
}

/// Returns the energy that a contact loses in the tick \[J\].
///
/// The change of penetration is over two ticks, so one tick has half of the energy that the potential releases if a
/// pull is left out. The viscosity loses its mean force (z/2) s times half the motion, s/2: z s²/4.
pub(super) fn heat<R: Real>(t: &ActiveContact<R>, tables: &[Table<R>]) -> R {
    match t.curve {
        Some(curve) if t.clip && t.p <= R::ZERO => R::of(0.5) * (curve.released)(&t.coef, tables, t.from, t.at),
        _ => R::of(0.25) * t.z * t.at * t.at,
    }
}
