//! A linear link whose force is taken from before and after the tick: REF, RES and FRO by the methods `centred` and
//! `implicit` (docs/numerics.md §1.3, eq. 1′, and §3.1).
//!
//! Equation: F = k (θ e₊ + (1 − 2θ) e + θ e₋) + z (e₊ − e₋)/2T. `centred` is θ = 0. Parameters: k \[N/m\], z \[N s/m\], θ.
//! Stability: T²k(1 − 4θ)(1/m₁ + 1/m₂) < 4 for one link, whatever z; from θ = ¼ on any k. Source:
//! docs/numerics.md §3.1. Test: A14, A15, H04.
//!
//! Decides that the law itself sees only the explicit part, F₀ = k e + z w, as every law does; with u the change of
//! motion in the tick, what is missing is (θk + z/2T) times the change of w, which [`crate::method::implicit`] solves for
//! all such links at once.

use super::{Bound, Law, LawEntry, LawFns, Phi, linear_lost, linear_stored};
use crate::kind::{Need, Param, Type, Unit};
use crate::numeric::{Real, Table};
use crate::tuning::Method;

/// The methods of linear links, by name.
pub const METHOD: Param = Param::new(
    "method",
    Type::Choice(Method::OF_LINK),
    Need::Optional,
    "ca: explicit, as in the field; centred: viscosity without a limit and of second order; implicit: stiffness without \
     a limit too. Of the group or the model if left out",
);
/// The methods of a group, by name: those of links, and the modes of what is linear in it.
pub const OF_GROUP: Param =
    Param::new("method", Type::Choice(Method::OF_GROUP), Need::Optional, "how linear links and cells are computed");
/// The methods of the model, by name: those of a group, and one for all masses at once.
pub const OF_MODEL: Param = Param::new(
    "method",
    Type::Choice(Method::WORDS),
    Need::Optional,
    "how linear links and cells are computed, or, by pefrl, everything",
);
/// Weight of the time to come.
pub const THETA: Param = Param::number(
    "theta",
    Unit::NONE,
    (0.0, 1.0),
    Need::Optional,
    "implicit: share of the force from the tick before and the tick after, each; from 1/4 on without a limit, 1/2 does \
     not ring; 1/2 if left out",
)
.for_good();

/// The law; parameters k, z and θ in this order, whatever the kind.
pub static LAW: Law = Law { implicit: true, ..Law::of::<Implicit, 3, 0>("REF implicit") };

/// The functions of its law over `R`.
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
