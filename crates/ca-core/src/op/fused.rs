//! Fused: the linear links of a row and the integration of its masses in one pass, without the array of forces between.
//!
//! A mass receives the force of the link before it, that of the link after it, and then the sum of what others gave:
//! (Fᵢ − Fᵢ₋₁) + f. Decides that the compiler fuses a row only where the list of passes sums in that order too, so that
//! the bits are those of a run and an integration one after the other: another order would make another scene of many
//! more. Forces stand in [`State::tap`] between the two loops: one loop would need the vector before one lane on, for
//! which the portable vectors there are take longer than a second loop. In single precision there is none, where runs
//! are half as long.

use super::wide::{self, Body};
use super::{Kernel, Law, Op};
use crate::layout::Layout;
use crate::phi::{fro, ref_, res};
use crate::real::Real;
use crate::state::State;

/// The fused pass of rows of this law, for masses that only have inertia or, with `own`, that have springs and dampers of
/// their own. `None` for laws that are not linear or have memory.
pub fn kernel(law: &Law, own: bool) -> Option<(&'static str, Kernel)> {
    if crate::real::SINGLE {
        return None;
    }
    let kernel: (&'static str, Kernel) = match (law, own) {
        (l, false) if core::ptr::eq(l, &raw const res::LAW) => ("RES, integrate MAS", fused::<true, false, false>),
        (l, true) if core::ptr::eq(l, &raw const res::LAW) => ("RES, integrate CEL", fused::<true, false, true>),
        (l, false) if core::ptr::eq(l, &raw const fro::LAW) => ("FRO, integrate MAS", fused::<false, true, false>),
        (l, true) if core::ptr::eq(l, &raw const fro::LAW) => ("FRO, integrate CEL", fused::<false, true, true>),
        (l, false) if core::ptr::eq(l, &raw const ref_::LAW) => ("REF, integrate MAS", fused::<true, true, false>),
        (l, true) if core::ptr::eq(l, &raw const ref_::LAW) => ("REF, integrate CEL", fused::<true, true, true>),
        _ => return None,
    };
    Some(kernel)
}

/// The two loops: forces of `n` links, then `n + 1` masses.
struct Fused<const SPRING: bool, const DAMPER: bool, const OWN: bool>;

fn fused<const SPRING: bool, const DAMPER: bool, const OWN: bool>(op: &Op, layout: &Layout, s: &mut State) {
    wide::wide::<Fused<SPRING, DAMPER, OWN>>(op, layout, s);
}

impl<const SPRING: bool, const DAMPER: bool, const OWN: bool> Body for Fused<SPRING, DAMPER, OWN> {
    #[inline(always)]
    fn run(op: &Op, layout: &Layout, s: &mut State) {
        let (n, all, at) = (op.n, layout.n_mat, op.mat..op.mat + op.n + 1);
        let column = |k: usize| &s.coef[op.coef + k * n..][..n];
        let force = &mut s.tap[..n];
        {
            let (x, x_next) = (&s.x[at.start..][..n], &s.x[at.start + 1..][..n]);
            let (d, d_next) = (&s.d[at.start..][..n], &s.d[at.start + 1..][..n]);
            match (SPRING, DAMPER) {
                (true, true) => {
                    let (k, z) = (column(0), column(1));
                    for i in 0..n {
                        force[i] = k[i] * (x_next[i] - x[i]) + z[i] * (d_next[i] - d[i]);
                    }
                }
                (true, false) => {
                    let k = column(0);
                    for i in 0..n {
                        force[i] = k[i] * (x_next[i] - x[i]);
                    }
                }
                _ => {
                    let z = column(0);
                    for i in 0..n {
                        force[i] = z[i] * (d_next[i] - d[i]);
                    }
                }
            }
        }
        let own = |k: usize| &s.coef[k * all..][at.clone()];
        let (p, q, c) = (own(0), own(1), own(2));
        let (x, d, f) = (&mut s.x[at.clone()], &mut s.d[at.clone()], &mut s.f[at.clone()]);
        let push = |i: usize, x: &mut Real, d: &mut Real, f: &mut Real, between: Real| {
            let sum = between + *f;
            *d = if OWN { p[i] * *d + q[i] * *x + c[i] * sum } else { *d + c[i] * sum };
            *x += *d;
            *f = 0.0;
        };
        push(0, &mut x[0], &mut d[0], &mut f[0], force[0]);
        push(n, &mut x[n], &mut d[n], &mut f[n], 0.0 - force[n - 1]);
        let m = n - 1;
        let (p, q, c) = (&p[1..][..m], &q[1..][..m], &c[1..][..m]);
        let (x, d, f) = (&mut x[1..][..m], &mut d[1..][..m], &mut f[1..][..m]);
        let (before, behind) = (&force[..m], &force[1..][..m]);
        for i in 0..m {
            let sum = (behind[i] - before[i]) + f[i];
            d[i] = if OWN { p[i] * d[i] + q[i] * x[i] + c[i] * sum } else { d[i] + c[i] * sum };
            x[i] += d[i];
            f[i] = 0.0;
        }
    }
}
