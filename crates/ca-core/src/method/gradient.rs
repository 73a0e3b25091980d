//! Discrete gradient: the push of a contact is the slope of its potential between the tick before and the tick after
//! (Chatziioannou and van Walstijn 2013; closed form in docs/numerics.md §3.3).
//!
//! Let a = η₋, s = η₊ (unknown), η* the penetration after the tick without this contact, and c = T²(1/m₁ + 1/m₂):
//! ```text
//! N = (U(s) − U(a)) / (s − a) + (z/2)(s − a)        s = η* − c N
//! ```
//! The work N(s − a)/2 is half of U(s) − U(a) plus the heat (z/4)(s − a)². With (U(η) + U(η₊))/2 as the stored energy
//! the ledger therefore balances at any stiffness. The left side rises with s, so there is one root. For a linear
//! spring the equation is piecewise quadratic: no iteration, and a square root only in the two ticks in which contact
//! begins or ends. For a power law it is convex, and a few Newton steps solve it. The release is quadratic for both.
//!
//! The damper acts while the contact is compressed at the tick itself, with the viscosity of that depth (Hunt and
//! Crossley: h k η^p). It enters by (1 + β)s = η* + βa − c·slope with β = cz/2.
//!
//! The closed form requires that no other such contact moves the same MAT, since c and η* omit the others, and a
//! gradient that does not turn during the tick, as on a line. At a modal mass c counts all modes ([`super::modes`]). On
//! a line with shared masses [`super::cluster`] runs instead, and in space [`super::quadratised`]. With
//! `sticky = false` a pull is left out; then s = η*, and half of U(a) − U(s) is lost.

use super::spring::{Contact, Spring, after};
use super::{free_motion, mobility};
use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::op::{Energies, Law, LawFns, Op, SolveStage, Together};
use crate::state::State;

/// Makes a one-sided spring; if it cannot act alone, one of `others` runs. Memory: heat of the tick \[J\].
pub const fn law<S: Spring<f64>>(spring: Law, others: Together) -> Law {
    Law { mem: 1, stage: SolveStage::Single(others), fns: fns::<f64, S>(spring.fns), ..spring }
}

/// Makes its functions from the functions of the spring.
pub const fn fns<R: Real, S: Spring<R>>(spring: LawFns<R>) -> LawFns<R> {
    LawFns {
        start: |_, _, mem| mem.fill(R::ZERO),
        energies: Energies::kept(spring.energies.stored, |_, mem, _, _| mem[0]),
        kernel: |_| push::<R, S>,
        ..spring
    }
}

fn push<R: Real, S: Spring<R>>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    for i in 0..op.n {
        let contact = Contact::<R, S>::read(s, op.coef, op.n, i);
        let [p, q] = layout.links.ends[op.first + i].map(|m| m as usize);
        let e = s.x[q] - s.x[p] + layout.links.e0[op.first + i];
        let now = contact.penetration(e);
        let a = now + contact.side * (s.d[q] - s.d[p]);
        let free = contact.penetration(e + (free_motion(layout, s, q) - free_motion(layout, s, p)));
        let z = if now > R::ZERO { contact.spring.viscosity(contact.k, now) } else { R::ZERO };
        let (mut force, mut heat) = (R::ZERO, R::ZERO);
        if free > R::ZERO || a > R::ZERO || z > R::ZERO {
            let c = mobility(layout, s, p) + mobility(layout, s, q);
            let beta = R::of(0.5) * c * z;
            let h = R::of(0.5) * c * contact.k / (R::of(1.0) + beta);
            let to = after(contact.spring, (free + beta * a) / (R::of(1.0) + beta), a, h);
            force = contact.slope(to, a);
            let moved = if S::HARDENS { (free - a - c * force) / (R::of(1.0) + beta) } else { to - a };
            force += R::of(0.5) * z * moved;
            heat = R::of(0.25) * z * moved * moved;
            if contact.clip && force < R::ZERO {
                (force, heat) = (R::ZERO, R::of(0.5) * (contact.potential(a) - contact.potential(free)));
            }
        }
        let tension = -contact.side * force;
        s.f[p] += tension;
        s.f[q] -= tension;
        s.links.mem[op.mem + i] = heat;
        if op.form.tap {
            s.links.tap[op.tap + i] = tension;
        }
    }
}
