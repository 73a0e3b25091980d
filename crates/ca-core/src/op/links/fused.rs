//! The links of a row and the integration of its masses in one pass, without an intermediate pass over forces.
//!
//! A mass receives the force of the link before it, then of the link after it, and then the sum of all others: (Fᵢ −
//! Fᵢ₋₁) + f. The compiler fuses a row only if the list of passes sums in that order too, so the bits equal a run
//! followed by an integration. Another order would change the bits of many more scenes.
//!
//! Forces are stored in [`LinkState::tap`] between two loops, with a 0 on either side, so that each loop vectorises. A
//! single loop would have to shift vectors by a lane, which with portable vectors takes longer than the second loop.

use super::run;
use crate::law::Phi;
use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd};
use crate::state::State;
use core::marker::PhantomData;

/// The pass of `op.n` links, whose forces are stored from `op.tap` ≥ 1 on, and of `op.n + 1` masses from `op.mat` on.
/// With `OWN` the masses have their own springs and dampers.
pub struct Fused<P, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool>(PhantomData<P>);

impl<R: Real, P: Phi<C, M>, const C: usize, const M: usize, const OFFSET: bool, const OWN: bool> Body<R>
    for Fused<P, C, M, OFFSET, OWN>
{
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        run::links::<R, P, C, M, OFFSET>(op, layout, s);
        let (n, masses, first) = (layout.counts.n_mat, op.n + 1, op.tap - 1);
        (s.links.tap[first], s.links.tap[first + masses]) = (R::ZERO, R::ZERO);
        let [before, behind] = [first, first + 1].map(|at| &s.links.tap[at..][..masses]);
        let [p, q, c]: [&[R]; 3] = [0, 1, 2].map(|k| &s.coef[k * n + op.mat..][..masses]);
        let (x, d, f) = (&mut s.x[op.mat..][..masses], &mut s.d[op.mat..][..masses], &mut s.f[op.mat..][..masses]);
        for i in 0..masses {
            let sum = (behind[i] - before[i]) + f[i];
            d[i] = if OWN { p[i] * d[i] + q[i] * x[i] + c[i] * sum } else { d[i] + c[i] * sum };
            x[i] += d[i];
            f[i] = R::ZERO;
        }
    }
}
