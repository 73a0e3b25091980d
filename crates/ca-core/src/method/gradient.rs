//! Discrete gradient: the push of a contact as the slope of its potential between the tick before and the tick after
//! (Chatziioannou and van Walstijn 2013; in closed form, numerics 3.3).
//!
//! With a = η₋, s = η₊ unknown, η* the penetration after the tick without this contact and c = T²(1/m₁ + 1/m₂):
//! ```text
//! N = (U(s) − U(a)) / (s − a) + (z/2)(s − a)        s = η* − c N
//! ```
//! The work N(s − a)/2 is then half of U(s) − U(a) plus the heat (z/4)(s − a)², so with (U(η) + U(η₊))/2 as the energy
//! held the books close for any stiffness. For a linear spring the equation is piecewise quadratic and monotone: one
//! root, no iteration, and a square root only in the two ticks in which it begins or ends. The damper acts while
//! pressed together at the tick itself; it is folded in by (1 + β)s = η* + βa − c·slope with β = cz/2.
//!
//! Only sound where no other such contact moves the same place, since c and η* know nothing of it, and for a gradient
//! that does not turn during the tick: on a line. Everywhere else [`super::quadratised`] runs instead. With
//! `sticky = false` a pull is left out; then s = η*, and U(a) − U(s), half of it, is lost.

use super::{Buffer, goes, mobility};
use crate::layout::Layout;
use crate::op::Op;
use crate::op::law::{Law, Turn};
use crate::state::State;

/// A one-sided spring by this method; where it may not act alone, `other` runs. Memory: heat of the tick \[J\].
pub const fn law(spring: Law, other: &'static Law) -> Law {
    Law {
        mem: 1,
        start: |_, _, mem| mem.fill(0.0),
        lost: |_, mem, _, _| mem[0],
        kernel: |_| push,
        turn: Turn::Alone(other),
        ..spring
    }
}

/// The penetration after the tick: the root of s + 2h·(slope of η₊²/2 from a to s) = e.
fn after(e: f64, a: f64, h: f64) -> f64 {
    let p = a + e;
    if a >= 0.0 {
        if e >= h * a {
            return (e - h * a) / (1.0 + h);
        }
        let q = libm::sqrt((a - e) * (a - e) + 4.0 * h * a * a);
        return if p > 0.0 { 2.0 * a * (e - h * a) / (p + q) } else { 0.5 * (p - q) };
    }
    if e <= 0.0 {
        return e;
    }
    let q = libm::sqrt(p * p - 4.0 * (1.0 + h) * e * a);
    if p >= 0.0 { (p + q) / (2.0 * (1.0 + h)) } else { -2.0 * e * a / (q - p) }
}

/// (U(s) − U(a)) / (s − a) for U = k η₊²/2, without its cancellation.
fn slope(k: f64, s: f64, a: f64) -> f64 {
    match (s > 0.0, a > 0.0) {
        (true, true) => 0.5 * k * (s + a),
        (true, false) => 0.5 * k * s * (s / (s - a)),
        (false, true) => 0.5 * k * a * (a / (a - s)),
        (false, false) => 0.0,
    }
}

/// Applies the contacts of `op`, one by one.
fn push(op: &Op, layout: &Layout, s: &mut State) {
    for i in 0..op.n {
        let buffer = Buffer::read(s, op.coef, op.n, i);
        let [p, q] = layout.ends[op.first + i].map(|m| m as usize);
        let e = s.x[q] - s.x[p] + layout.e0[op.first + i];
        let now = buffer.penetration(e);
        let a = now + buffer.side * (s.d[q] - s.d[p]);
        let free = buffer.penetration(e + (goes(layout, s, q) - goes(layout, s, p)));
        let z = if now > 0.0 { buffer.z } else { 0.0 };
        let (mut force, mut heat) = (0.0, 0.0);
        if free > 0.0 || a > 0.0 || z > 0.0 {
            let c = mobility(layout, s, p) + mobility(layout, s, q);
            let beta = 0.5 * c * z;
            let to = after((free + beta * a) / (1.0 + beta), a, 0.5 * c * buffer.k / (1.0 + beta));
            force = slope(buffer.k, to, a) + 0.5 * z * (to - a);
            heat = 0.25 * z * (to - a) * (to - a);
            if buffer.clip && force < 0.0 {
                (force, heat) = (0.0, 0.5 * (buffer.potential(a) - buffer.potential(free)));
            }
        }
        let tension = -buffer.side * force;
        s.f[p] += tension;
        s.f[q] -= tension;
        s.mem[op.mem + i] = heat;
        if op.form.tap {
            s.tap[op.tap + i] = tension;
        }
    }
}
