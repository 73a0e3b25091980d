//! Energy quadratisation: the energy of a contact is the square of a number that is carried along, so that the push is
//! linear in the motion to come and all active contacts are one linear system (Ducceschi, Bilbao, Willemsen and
//! Serafin, JASA 149(5), 2021; docs/numerics.md §3.4). For contacts in space, and for all that share masses with these.
//!
//! ψ stands for √(2U) between ticks; with s the change of penetration over two ticks and γ known at the tick,
//! ```text
//! ψ₊ = ψ + γ s/2        N = γ (ψ + ψ₊)/2 + z s/2 = γψ + R s        R = γ²/4 + z/2
//! ```
//! so that the work N s/2 is (ψ₊² − ψ²)/2 plus the heat z s²/4, for **any** γ. Pressed together, γ is the slope of
//! √(2U) at the tick, √k of a linear spring; ψ and −ψ are the same energy, so ψ is kept positive and the contact pushes.
//! Once apart, γ is what gives all of ψ back in this tick: ψ₊ = 0 with s = s* − Wγψ/2 asks Wψγ²/2 − s*γ − 2ψ = 0, whose positive root
//! is 4ψ/(q − s*), q = √(s*² + 4Wψ²), with s* the change that all other forces would cause and W the mobility of this
//! contact; one that closes again keeps ψ for then. A contact that holds nothing and is opening holds on to nothing. Of
//! several that let go at once ψ falls over some ticks, and below `NOTHING` there is none: the system would have 1/γ², which
//! is infinite.
//!
//! With G the gradients of the active penetrations and W = G M⁻¹Gᵀ T² their mobilities, s = s* − W N. In terms of
//! y = N − γψ, which is R s:
//! ```text
//! (W + R⁻¹) y = s* − W γψ
//! ```
//! Symmetric and positive definite, the right side within the range of W, and what W cannot tell apart (a mass held
//! from more sides than it has axes) stays zero in y. Solved by conjugate gradients scaled by the diagonal: nothing is
//! stored but one vector over places, contacts that share nothing are done in one step, and no number of them is too
//! large. A factorisation was the alternative; it needs room that grows with the square. s is then taken as y/R, so an
//! error ε of the solver makes no more energy than N·ε/2, which `EXACT` keeps at the rounding of the blow itself.
//!
//! Friction joins in with γ = 0 and the viscosity of its secant (`friction.rs` beside this).
//!
//! With `sticky = false` contacts that would pull are taken out and the rest is solved again, until none does; their ψ
//! follows the motion as far as that loses energy.

use super::spring::{Contact, Spring};
use super::{cluster, free_motion, mobility, modes};
use crate::numeric::{Precision, Real};
use crate::op::layout::{Layout, MeasureKind};
use crate::op::links::measure::{Along, Line, Measure, Radial};
use crate::op::{Energies, Form, Kernel, Law, LawFns, Op, SolveStage};
use crate::state::State;
use crate::state::active_contacts::{ActiveContact, ActiveContacts, Curve, Part};
use nalgebra::Vector3;

/// The residual is brought below this part of what it was, squared.
fn exact<R: Real>() -> R {
    R::of(if matches!(R::PRECISION, Precision::Single) { 3e-13 } else { 1e-30 })
}

/// Motion that holds less \[J\] is left alone: the squares it is solved by are none any more.
fn nothing<R: Real>() -> R {
    R::of(if matches!(R::PRECISION, Precision::Single) { 1e-35 } else { 1e-200 })
}

/// A one-sided spring by this method. Memory: ψ \[√J\], heat of the tick \[J\].
pub const fn law<S: Spring<f64>>(spring: Law) -> Law {
    Law { mem: 2, stage: SolveStage::Coupled(None), fns: fns::<f64, S>(spring.fns), ..spring }
}

/// Its functions, made of the functions of the spring.
pub const fn fns<R: Real, S: Spring<R>>(spring: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |c, [e, _], mem| {
            let b = Contact::<R, S>::of(c);
            mem[0] = (R::of(2.0) * b.potential(b.penetration(e))).sqrt();
            mem[1] = R::ZERO;
        },
        energies: Energies::kept(|_, mem, _, _, _| R::of(0.5) * mem[0] * mem[0], |_, mem, _, _| mem[1]),
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

/// Collects the contacts of `op` that act in this tick.
fn gather<R: Real, S: Spring<R>, G: Measure>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let contact = Contact::<R, S>::read(s, op.coef, op.n, i);
        let ends = layout.links.ends[op.first + i].map(|m| m as usize);
        let at = if G::SPACE { layout.links.reach[op.ports.reach + i] } else { [R::ZERO; 4] };
        let mem = op.mem + 2 * i;
        let psi = s.links.mem[mem];
        s.links.mem[mem + 1] = R::ZERO;
        if op.form.tap {
            s.links.tap[op.tap + i] = R::ZERO;
        }
        if psi == R::ZERO {
            // idle, without the square root
            let d = contact.d.max(R::ZERO);
            if G::square(&s.x, ends, &at).is_some_and(|l| contact.side * (d * d - l) < R::ZERO) {
                continue;
            }
        }
        let measured = G::measure(&s.x, &s.d, ends, &at);
        let eta = contact.penetration(measured.e + layout.links.e0[op.first + i]);
        if eta < R::ZERO && psi * psi <= nothing() {
            s.links.mem[mem] = R::ZERO;
            continue;
        }
        let link = reach::<R, G>(op, layout, s, i, contact.side, measured.gradient());
        let (free, w) = (link.free, link.diag);
        let (gamma, z) = match (eta >= R::ZERO, free < R::ZERO) {
            (true, opening) => {
                let gamma = if opening && psi == R::ZERO { R::ZERO } else { contact.spring.gamma(contact.k, eta) };
                (gamma, contact.spring.viscosity(contact.k, eta))
            }
            (false, true) => (R::of(4.0) * psi / ((free * free + R::of(4.0) * w * psi * psi).sqrt() - free), R::ZERO),
            (false, false) => (R::ZERO, R::ZERO),
        };
        join(s, ActiveContact { clip: contact.clip, open: eta < R::ZERO, gamma, psi, z, ..link });
    }
}

/// Link `i` of `op`, of which `u` is the gradient of the elongation, as one that may act: what all other forces would
/// do to it, and its mobility \[m/N\] on the diagonal.
pub(super) fn reach<R: Real, G: Measure>(
    op: &Op<R>,
    layout: &Layout<R>,
    s: &State<R>,
    i: usize,
    side: R,
    u: Vector3<R>,
) -> ActiveContact<R> {
    let g: [R; 3] = (u * -side).into();
    let (ends, axes) = (layout.links.ends[op.first + i], if G::SPACE { 3 } else { 1 });
    let (mut free, mut w) = (R::ZERO, R::ZERO);
    for (k, g) in g[..axes].iter().enumerate() {
        let [a, b] = ends.map(|m| m as usize + k);
        free += *g * (free_motion(layout, s, b) + s.d[b] - free_motion(layout, s, a) - s.d[a]);
        w += *g * *g * (mobility(layout, s, a) + mobility(layout, s, b));
    }
    let tap = op.form.tap.then_some(op.tap + i);
    ActiveContact { ends, axes, g, mem: op.mem + 2 * i, tap, side, free, diag: w, own: w, ..ActiveContact::default() }
}

/// Adds a link to those of this tick, if it does anything.
pub(super) fn join<R: Real>(s: &mut State<R>, link: ActiveContact<R>) {
    let stiff = R::of(0.25) * link.gamma * link.gamma + R::of(0.5) * link.z;
    let touches = &mut s.links.touches;
    let Some(t) = touches.list.get_mut(touches.n).filter(|_| stiff > R::ZERO) else { return };
    *t = ActiveContact { stiff, bias: link.gamma * link.psi, diag: link.diag + R::of(1.0) / stiff, ..link };
    touches.n += 1;
}

/// Adds a link whose push is a curve.
pub(super) fn enter<R: Real>(s: &mut State<R>, link: ActiveContact<R>) {
    let touches = &mut s.links.touches;
    let Some(t) = touches.list.get_mut(touches.n) else { return };
    *t = link;
    touches.n += 1;
}

/// What a push does: the mobility of each place, and where masses go by their modes (`MODES`) how these couple them.
pub(super) struct Response<'a, R: Real, const MODES: bool> {
    layout: &'a Layout<R>,
    mobility: &'a [R],
    push: &'a mut [R],
    tap: &'a mut [R],
}

/// Sets `q` of each contact to W p.
pub(super) fn respond<R: Real, const MODES: bool>(list: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) {
    let Response { layout, mobility, push, tap } = to;
    let places = |t: &ActiveContact<R>| {
        let ([a, b], n) = (t.ends.map(|m| m as usize), t.axes);
        (0..n).map(move |k| (a + k, b + k, k))
    };
    for t in &*list {
        for (a, b, k) in places(t) {
            push[a] -= t.g[k] * t.p;
            push[b] += t.g[k] * t.p;
        }
    }
    if MODES {
        modes::couple(layout, push, tap);
    }
    for t in &mut *list {
        t.q = places(t).map(|(a, b, k)| t.g[k] * (mobility[b] * push[b] - mobility[a] * push[a])).sum();
    }
    for t in &*list {
        for (a, b, _) in places(t) {
            (push[a], push[b]) = (R::ZERO, R::ZERO);
        }
    }
    if MODES {
        modes::clear(layout, push);
    }
}

/// Solves for `y` of all contacts listed.
pub(super) fn conjugate<R: Real, const MODES: bool>(list: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) {
    for t in &mut *list {
        t.p = t.bias;
    }
    respond(list, to);
    let mut rho = R::ZERO;
    for t in &mut *list {
        (t.y, t.r) = (R::ZERO, t.free - t.q);
        t.p = t.r / t.diag;
        rho += t.r * t.p;
    }
    let goal = (exact::<R>() * rho).max(nothing());
    // in exact arithmetic as many steps as contacts; rounding may ask for more
    for _ in 0..10 * list.len() + 10 {
        // what is not finite is not for here to find out
        if rho.wide().is_nan() || rho <= goal {
            break;
        }
        respond(list, to);
        let mut along = R::ZERO;
        for t in &mut *list {
            t.q += t.p / t.stiff;
            along += t.p * t.q;
        }
        let (step, before) = (rho / along, rho);
        rho = R::ZERO;
        for t in &mut *list {
            t.y += step * t.p;
            t.r -= step * t.q;
            rho += t.r * t.r / t.diag;
        }
        for t in &mut *list {
            t.p = t.r / t.diag + rho / before * t.p;
        }
    }
}

/// Applies the push of a contact to its ends.
fn apply<R: Real>(t: &ActiveContact<R>, f: &mut [R], taps: &mut [R]) {
    for k in 0..t.axes {
        let [a, b] = t.ends.map(|m| m as usize + k);
        f[a] += t.g[k] * t.p;
        f[b] -= t.g[k] * t.p;
    }
    if let Some(tap) = t.tap {
        taps[tap] = -t.side * t.p;
    }
}

/// Computes the pushes of all contacts collected and applies them.
pub fn solve<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    together::<R, false>(op, layout, s);
}

/// The same where several act at masses of one group that goes by its modes.
pub fn solve_modes<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    together::<R, true>(op, layout, s);
}

/// Brings the contacts that `are` so to the front, and counts them.
fn gathered<R: Real>(all: &mut [ActiveContact<R>], are: impl Fn(&ActiveContact<R>) -> bool) -> usize {
    let mut n = 0;
    for i in 0..all.len() {
        if are(&all[i]) {
            all.swap(i, n);
            n += 1;
        }
    }
    n
}

/// Solves for contacts that go by ψ; those that would pull are left behind the rest, whose number it returns.
fn linear<R: Real, const MODES: bool>(all: &mut [ActiveContact<R>], to: &mut Response<R, MODES>) -> usize {
    let mut acting = all.len();
    loop {
        conjugate(&mut all[..acting], to);
        let before = acting;
        let mut i = 0;
        while i < acting {
            if all[i].clip && all[i].gamma * all[i].psi + all[i].y < R::ZERO {
                acting -= 1;
                all.swap(i, acting);
            } else {
                i += 1;
            }
        }
        if acting == before {
            return acting;
        }
    }
}

#[inline(always)]
fn together<R: Real, const MODES: bool>(_op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    let ActiveContacts { n, list, push, unsolved } = &mut s.links.touches;
    let mut to =
        Response::<R, MODES> { layout, mobility: &s.coef[2 * layout.counts.n_mat..], push, tap: &mut s.links.tap };
    let all = &mut list[..core::mem::take(n)];
    if all.iter().all(|t| t.part == Part::Waits) {
        return;
    }
    let acting = if all.iter().any(|t| t.curve != Curve::Quadratised) {
        *unsolved += u64::from(!cluster::newton(all, &mut to));
        gathered(all, |t| t.part != Part::LeftOut)
    } else {
        linear(all, &mut to)
    };
    for t in &mut all[..acting] {
        if t.curve != Curve::Quadratised {
            s.links.mem[t.mem] = cluster::heat(t);
            apply(t, &mut s.f, &mut s.links.tap);
            continue;
        }
        let moved = t.y / t.stiff;
        t.p = t.gamma * t.psi + t.y;
        let left = (t.psi + R::of(0.5) * t.gamma * moved).abs();
        let nothing = t.open && t.psi * t.psi + left * left == t.psi * t.psi;
        s.links.mem[t.mem] = if nothing { R::ZERO } else { left };
        s.links.mem[t.mem + 1] = R::of(0.25) * t.z * moved * moved;
        apply(t, &mut s.f, &mut s.links.tap);
    }
    if acting < all.len() {
        for t in &mut all[acting..] {
            t.p = R::ZERO;
        }
        respond(
            all,
            &mut Response::<R, MODES> {
                layout,
                mobility: &s.coef[2 * layout.counts.n_mat..],
                push,
                tap: &mut s.links.tap,
            },
        );
        for t in &all[acting..] {
            let follows = t.psi + R::of(0.5) * t.gamma * (t.free - t.q);
            let left = follows.abs().min(t.psi);
            s.links.mem[t.mem] = left;
            s.links.mem[t.mem + 1] = R::of(0.5) * (t.psi - left) * (t.psi + left);
        }
    }
}
