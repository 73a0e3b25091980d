//! Discrete gradients solved together: contacts on a line that share masses (docs/numerics.md §3.3).
//!
//! Each contact pushes by the slope of its potential between the tick before and the tick after, as in [`super::gradient`], but the
//! penetration after the tick depends on all of them:
//! ```text
//! N_l = h_l(s_l)        s = s* − W N        h(s) = (U(a + s) − U(a)) / s + (z/2) s
//! ```
//! with s the change of penetration over two ticks, s* the change by all other forces, a the penetration before and W = T² G M⁻¹ Gᵀ. A
//! rising force makes h rise, so the step is the minimum of a strictly convex function and has one solution. Newton's method finds
//! it: with the tangent N ≈ h(s) + h′(s) (s₊ − s) every iteration is the linear system of [`super::quadratised`], which therefore also
//! takes contacts in space and friction that share masses with these. Contacts without slope do not enter.
//!
//! The energy held is U of the true penetration, so nothing drifts from it, and the balance holds for every stiffness. With
//! `sticky = false` a pull is left out: h is 0 there, and what U loses is heat.

use super::quadratised::{Response, conjugate, enter, reach, respond};
use super::spring::{Contact, Linear, Power, Spring};
use crate::numeric::{Precision, Real};
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure, Radial};
use crate::op::{Energies, Form, Kernel, Law, LawFns, Op, SolveStage};
use crate::state::State;
use crate::state::active_contacts::{ActiveContact, Curve, Part};

/// Newton steps of a tick at most; four are usual. From [`DAMPED`] on every second step is halved unless it is half
/// of the one before.
const STEPS: usize = 100;
const DAMPED: usize = 8;

/// A step that changes motion by this part of it is the last; below the second bound, a step that is hardly smaller than the
/// one before is rounding.
fn near<R: Real>() -> [R; 2] {
    (if matches!(R::PRECISION, Precision::Single) { [3e-7, 1e-4] } else { [4e-16, 1e-11] }).map(R::of)
}

/// A one-sided spring by this method, `at_modes` of masses that go by their modes. Memory: heat of the tick \[J\].
pub const fn law<S: Spring<f64>>(spring: Law, at_modes: &'static Law) -> Law {
    Law { mem: 1, stage: SolveStage::Coupled(Some(at_modes)), fns: fns::<f64, S>(spring.fns), ..spring }
}

/// Its functions, made of the functions of the spring.
pub const fn fns<R: Real, S: Spring<R>>(spring: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |_, _, mem| mem.fill(R::ZERO),
        energies: Energies::kept(spring.energies.stored, |_, mem, _, _| mem[0]),
        kernel: kernel::<R, S>,
        ..spring
    }
}

fn kernel<R: Real, S: Spring<R>>(form: Form) -> Kernel<R> {
    match form.measure {
        MeasureKind::Line => gather::<R, S, Line>,
        MeasureKind::Along => gather::<R, S, Along>,
        MeasureKind::Radial => gather::<R, S, Radial>,
    }
}

/// Collects the contacts of `op`: one that touches nothing may be pushed by another.
fn gather<R: Real, S: Spring<R>, G: Measure>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
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
        let at = if part == Part::Waits { link.free } else { contact.alone(from, link.free, link.own, z) };
        let mem = op.mem + i;
        enter(s, ActiveContact { mem, clip: contact.clip, curve: S::CURVE, coef, from, z, at, part, ..link });
    }
}

/// Push and its slope at the change of penetration `at` that is assumed.
fn push<R: Real>(t: &ActiveContact<R>) -> [R; 2] {
    let [push, slope] = match t.curve {
        Curve::Linear => Contact::<R, Linear<R>>::of(&t.coef).between(t.from, t.at),
        Curve::Power => Contact::<R, Power<R>>::of(&t.coef).between(t.from, t.at),
        Curve::Quadratised => [R::ZERO; 2],
    };
    let half = R::of(0.5) * t.z;
    let [push, slope] = [push + half * t.at, slope + half];
    if t.clip && push < R::ZERO { [R::ZERO; 2] } else { [push, slope] }
}

/// The potential of a contact before the tick less that after it \[J\].
fn released<R: Real>(t: &ActiveContact<R>) -> R {
    let [before, after] = [t.from, t.from + t.at].map(|eta| match t.curve {
        Curve::Linear => Contact::<R, Linear<R>>::of(&t.coef).potential(eta),
        Curve::Power => Contact::<R, Power<R>>::of(&t.coef).potential(eta),
        Curve::Quadratised => R::ZERO,
    });
    before - after
}

/// Solves for the pushes of all contacts: `p` is the push of each, `at` its change of penetration. False where the bound on
/// iterations was met.
pub(super) fn newton<R: Real, const MODES: bool>(all: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) -> bool {
    let (mut solved, mut before) = (false, R::INFINITY);
    let [last, rounded] = near::<R>();
    for step in 0..STEPS {
        let mut acting = 0;
        for i in 0..all.len() {
            let t = &mut all[i];
            if t.curve == Curve::Quadratised {
                (t.bias, t.stiff) = (t.gamma * t.psi, R::of(0.25) * t.gamma * t.gamma + R::of(0.5) * t.z);
                t.stiff = if t.part == Part::LeftOut { R::ZERO } else { t.stiff };
            } else {
                let [push, slope] = push(t);
                (t.bias, t.stiff) = (push - slope * t.at, slope);
            }
            if t.stiff > R::ZERO {
                t.diag = t.own + R::of(1.0) / t.stiff;
                all.swap(i, acting);
                acting += 1;
            }
        }
        conjugate(&mut all[..acting], to);
        for (i, t) in all.iter_mut().enumerate() {
            t.p = if i < acting { t.bias + t.y } else { R::ZERO };
        }
        respond(all, to);
        let (mut again, mut worst) = (false, R::ZERO);
        for (i, t) in all.iter_mut().enumerate() {
            // a push that is small among others has few digits, and so has the motion of one that is stiff
            let stiff = i < acting && t.stiff * t.own > R::of(1.0);
            let moved = if stiff { t.y / t.stiff } else { t.free - t.q };
            if t.curve == Curve::Quadratised {
                // one that would pull is left out for this tick
                if t.clip && t.p < R::ZERO {
                    (t.part, again) = (Part::LeftOut, true);
                }
                t.at = moved;
                continue;
            }
            let scale = t.free.abs().max(moved.abs()).max(t.from.abs());
            worst = worst.max((moved - t.at).abs() / scale.max(R::of(f64::MIN_POSITIVE)));
            t.r = moved;
        }
        let halved = step >= DAMPED && step % 2 == 1 && worst > R::of(0.5) * before;
        for t in all.iter_mut().filter(|t| t.curve != Curve::Quadratised) {
            t.at = if halved { R::of(0.5) * (t.at + t.r) } else { t.r };
        }
        if solved {
            // derivatives have arrived too, and the number stays what it is without them
            let keep = |found: R, now: R| R::of(found.wide()) + (now - R::of(now.wide()));
            for t in &mut *all {
                let [push, moved, y] = t.found;
                (t.p, t.at, t.y) = (keep(push, t.p), keep(moved, t.at), keep(y, t.y));
            }
            return true;
        }
        solved = !again && (worst <= last || !halved && worst <= rounded && worst > R::of(0.75) * before);
        before = worst;
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

/// Heat of the tick \[J\].
pub(super) fn heat<R: Real>(t: &ActiveContact<R>) -> R {
    if t.clip && t.p <= R::ZERO { R::of(0.5) * released(t) } else { R::of(0.25) * t.z * t.at * t.at }
}
