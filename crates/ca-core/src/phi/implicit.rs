//! A linear link whose force depends on the positions before and after the tick: REF, RES and FRO with the methods
//! `centred` and `implicit` (docs/numerics.md §1.3, eq. 1′, and §3.1).
//!
//! Equation: F = k (θ e₊ + (1 − 2θ) e + θ e₋) + z (e₊ − e₋)/2T. `centred` is θ = 0. Parameters: k \[N/m\], z \[N s/m\], θ.
//! Stability: T²k(1 − 4θ)(1/m₁ + 1/m₂) < 4 for one link, at any z; for θ ≥ ¼ at any k. Source:
//! docs/numerics.md §3.1. Test: A14, A15, H04.
//!
//! The law itself computes only the explicit part, F₀ = k e + z w, like every law. The missing part is (θk + z/2T)
//! times the change of w in the tick. [`crate::method::implicit`] solves for it for all such links at once.

use super::{Bound, Law, LawEntry, LawFns, Phi, linear_lost, linear_stored};
use crate::kind::{Need, Param, Type, Unit};
use crate::numeric::{Real, Table};
use crate::tuning::Method;

/// Parameter `method` of linear links.
pub const METHOD: Param = Param::new(
    "method",
    Type::Choice(Method::OF_LINK),
    Need::Optional,
    "ca: explicit; centred: stable at any viscosity, of second order; implicit: also stable at any stiffness; if left \
     out, as in the group or the model",
);
/// Parameter `method` of a group: the methods of links, `modal` and `auto`.
pub const OF_GROUP: Param = Param::new(
    "method",
    Type::Choice(Method::OF_GROUP),
    Need::Optional,
    "method for linear links and cells; auto: ca for these, and for each other link the method that conserves its \
     energy, unless the link names one",
);
/// Parameter `method` of the model: the methods of a group, and `pefrl` for all masses at once.
pub const OF_MODEL: Param = Param::new(
    "method",
    Type::Choice(Method::WORDS),
    Need::Optional,
    "method for linear links and cells, or, with pefrl, for everything; auto: ca for these, and for each other link \
     the method that conserves its energy, unless the link names one; with format 2, auto if left out",
);
/// Parameter `theta`: weight of the positions before and after the tick, each.
pub const THETA: Param = Param::number(
    "theta",
    Unit::NONE,
    (0.0, 1.0),
    Need::Optional,
    "implicit: weight of the positions before and after the tick, each; from 1/4 on stable at any stiffness, at 1/2 \
     without ringing; 1/2 if left out",
)
.for_good();

/// The law. Its parameters are k, z and θ in this order, for every kind.
pub static LAW: Law = Law { implicit: true, ..Law::of::<Implicit, 3, 0>("REF implicit") };

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 1] {
    [(LAW.code, LawFns::of::<Implicit, 3, 0>())]
}

/// Coefficients k, z/T, θ.
pub struct Implicit;

impl Phi<3, 0> for Implicit {
    const LINEAR: bool = true;
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 3] {
        let at = |i: usize| p.get(i).copied().flatten().unwrap_or(0.0);
        [at(0), at(1) / tick_dt, at(2)]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, z, _]: &[R; 3], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        k * e + z * w
    }
    #[inline(always)]
    fn stored<R: Real>(&[k, _, theta]: &[R; 3], _: &[R; 0], _: &[Table<R>], e0: R, e1: R) -> R {
        linear_stored(k, -R::of(2.0) * theta * k, e0, e1)
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, z, _]: &[R; 3], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        linear_lost(z, e)
    }
    fn bound(&[k, z, theta]: &[f64; 3], _: &[Table]) -> Bound {
        Bound { k, z, linear: true, lift: 4.0 * theta * k, centred: true, ..Bound::default() }
    }
}
