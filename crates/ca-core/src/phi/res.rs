//! RES: a spring.
//!
//! Equation: F = k e. Parameters: k \[N/m\] ≥ 0. Source: CMJ 1993. Stability: T²k(1/m₁ + 1/m₂) < 4 for one link.
//! Test: A01, A03, A09.

use super::implicit::{METHOD, THETA};
use super::{ALONG, BETWEEN, Bound, L0, Law, LawEntry, LawFns, PAIRS, Phi, SOFTEN, linear_stored};
use crate::kind::{Kind, Need, POSITIVE, Param, Role, Unit};
use crate::law::Number;
use crate::numeric::{Real, Table};

/// RES in the catalog.
pub static KIND: Kind = Kind {
    code: "RES",
    title: "spring",
    equation: "F = k e",
    doc: "Pulls its ends together in proportion to their elongation, and loses no energy.",
    source: &["CMJ 1993"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Required, "stiffness"),
        L0,
        PAIRS,
        ALONG,
        SOFTEN,
        METHOD,
        THETA,
    ],
    one_of: &[],
    example: r#"
[SOL]
wall = {}
[MAS]
bob = { m = "1 g", dx0 = "0.5 mm" }
[RES]
spring = { between = ["wall", "bob"], k = "3 kN/m" }
[FRO]
air = { between = ["wall", "bob"], z = "4 mN s/m" }
[SOX]
out = { from = "bob", gain = 1000 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k");

/// The law of RES. It also replaces REF without viscosity.
pub static LAW: Law = Law::of::<Res, 1, 0>("RES");

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 1] {
    [(LAW.code, LawFns::of::<Res, 1, 0>())]
}

/// F = k e
pub struct Res;

impl Phi<1, 0> for Res {
    const LINEAR: bool = true;
    const WIDE: bool = true;
    fn coefs(p: &[Option<f64>], _te: f64) -> [f64; 1] {
        [p[at::K].unwrap_or(0.0)]
    }
    #[inline(always)]
    fn linear<N: Number>(&[k]: &[N; 1], e: N, _w: N) -> N {
        k * e
    }
    #[inline(always)]
    fn force<R: Real>(c: &[R; 1], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        Self::linear(c, e, w)
    }
    #[inline(always)]
    fn stored<R: Real>(&[k]: &[R; 1], _: &[R; 0], _: &[Table<R>], e0: R, e1: R) -> R {
        linear_stored(k, R::ZERO, e0, e1)
    }
    fn bound(&[k]: &[f64; 1], _: &[Table]) -> Bound {
        Bound { k, linear: true, ..Bound::default() }
    }
}
