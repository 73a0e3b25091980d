//! PEFRL: a tick of fourth order for conservative models, as five drifts and four kicks (docs/numerics.md §3.1).
//!
//! Equation: x ← x + ξ d; d ← d + (½ − λ) A(x); x ← x + χ d; d ← d + λ A(x); x ← x + (1 − 2(χ + ξ)) d; then the same
//! steps in reverse order, with A = Q x + C f the change of motion that a tick of this force would make, and d = v T.
//! Stability: T²k/m < 8.9368 for an oscillator. Source: Omelyan, Mryglod & Folk, Comput. Phys. Commun. 146 (2002).
//! Test: the orders, the limit, and B01, B03.
//!
//! A composition, unlike a modified equation, works for any force that depends on positions alone. It is symplectic and
//! reversible, so energy ripples and does not drift. The compiler refuses forces that depend on motion or have memory.

use crate::numeric::Real;
use crate::op::Op;
use crate::op::layout::Layout;
use crate::op::wide::{Body, Simd, wide};
use crate::state::State;

const XI: f64 = 0.178_617_895_844_809_1;
const LAMBDA: f64 = -0.212_341_831_062_605_4;
const CHI: f64 = -0.066_264_582_669_818_5;

/// Shares of a tick of the drifts.
pub const DRIFTS: [f64; 5] = [XI, CHI, 1.0 - 2.0 * (CHI + XI), CHI, XI];
/// Shares of a tick of the kicks between them.
pub const KICKS: [f64; 4] = [0.5 - LAMBDA, LAMBDA, LAMBDA, 0.5 - LAMBDA];

/// Stiffness T²k/m from which on an oscillator grows: where [`explicit`] reaches 4, the limit of the explicit scheme.
pub const LIMIT: f64 = 8.936_808_587_521_949;

/// Returns the stiffness kT²/m with which the explicit scheme has the frequency that this method has with `a`: 2 less
/// the trace of a tick. Up to a²/12 it equals 2 − 2 cos √a, the exact pitch.
pub fn explicit(a: f64) -> f64 {
    a * (1.0 + a * (-1.0 / 12.0 + a * (2.656_695_865_675_389e-3 + a * -2.782_479_566_657_611_6e-5)))
}

/// Moves all slots by the share [`DRIFTS`]`[op.first]` of their motion, and clears their forces.
pub fn drift<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    wide::<R, Drift>(op, layout, s);
}

struct Drift;

impl<R: Real> Body<R> for Drift {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, _: &Layout<R>, s: &mut State<R>) {
        let (n, share) = (op.n, R::of(DRIFTS[op.first]));
        for ((x, d), f) in s.x[..n].iter_mut().zip(&s.d[..n]).zip(&mut s.f[..n]) {
            *x += share * *d;
            *f = R::ZERO;
        }
    }
}

/// Changes the motion of all slots by the share [`KICKS`]`[op.first]` of a tick of their force.
pub fn kick<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    wide::<R, Kick<false>>(op, layout, s);
}

/// Does the same, with the springs of cells.
pub fn kick_own<R: Real>(op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
    wide::<R, Kick<true>>(op, layout, s);
}

struct Kick<const OWN: bool>;

impl<R: Real, const OWN: bool> Body<R> for Kick<OWN> {
    #[inline(always)]
    fn run<S: Simd>(_: S, op: &Op<R>, layout: &Layout<R>, s: &mut State<R>) {
        let (n, share) = (op.n, R::of(KICKS[op.first]));
        let c = &s.coef[2 * layout.counts.n_mat..][..n];
        for ((d, f), c) in s.d[..n].iter_mut().zip(&s.f[..n]).zip(c) {
            *d += share * (*c * *f);
        }
        if OWN {
            let q = &s.coef[layout.counts.n_mat..][..n];
            for ((d, x), q) in s.d[..n].iter_mut().zip(&s.x[..n]).zip(q) {
                *d += share * (*q * *x);
            }
        }
    }
}
