//! REF: a spring and a damper side by side.
//!
//! Equation: F = k e + (z/T) w. Parameters: k \[N/m\] ≥ 0, z \[N s/m\] ≥ 0. Source: CMJ 1993.
//! Stability: (T²k + 2Tz)(1/m₁ + 1/m₂) < 4 for one link (docs/numerics.md §1.3). Test: A04, A10.
//! Without viscosity RES runs instead, without stiffness FRO, unless the parameter is live.

use super::implicit::{METHOD, THETA};
use super::{
    ALONG, BETWEEN, Bound, L0, Law, LawEntry, LawFns, PAIRS, Phi, SOFTEN, fro, linear_lost, linear_stored, res,
};
use crate::kind::{Kind, Need, POSITIVE, Param, Role, Unit};
use crate::law::Number;
use crate::numeric::{Real, Table};

/// REF in the catalog.
pub static KIND: Kind = Kind {
    code: "REF",
    title: "spring and damper",
    equation: "F = k e + z de/dt",
    doc: "A spring and a damper side by side: the ordinary link of a vibrating structure.",
    source: &["CMJ 1993"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Default(0.0), "stiffness"),
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity"),
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
[REF]
spring = { between = ["wall", "bob"], k = "7.6 kN/m", z = "5 mN s/m" }
[SOX]
out = { from = "bob", gain = 1000 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", Z = "z");

/// The law of REF.
pub static LAW: Law =
    Law::of::<Ref, 2, 0>("REF").or(&[&res::LAW, &ZONLY], |p| match (p[at::K].is_zero(), p[at::Z].is_zero()) {
        (_, true) => Some(&res::LAW),
        (true, false) => Some(&ZONLY),
        _ => None,
    });

/// FRO with the parameters of REF.
pub static ZONLY: Law =
    Law::of::<fro::Fro, 1, 0>("FRO").loaded_by(|p, tick_dt, out| out[0] = p[at::Z].unwrap_or(0.0) / tick_dt);

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 1] {
    [(LAW.code, LawFns::of::<Ref, 2, 0>())]
}

/// F = k e + (z/T) w
pub struct Ref;

impl Phi<2, 0> for Ref {
    const LINEAR: bool = true;
    const WIDE: bool = true;
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 2] {
        [p[at::K].unwrap_or(0.0), p[at::Z].unwrap_or(0.0) / tick_dt]
    }
    #[inline(always)]
    fn linear<N: Number>(&[k, z]: &[N; 2], e: N, w: N) -> N {
        k * e + z * w
    }
    #[inline(always)]
    fn force<R: Real>(c: &[R; 2], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        Self::linear(c, e, w)
    }
    #[inline(always)]
    fn stored<R: Real>(&[k, z]: &[R; 2], _: &[R; 0], _: &[Table<R>], e0: R, e1: R) -> R {
        linear_stored(k, z, e0, e1)
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, z]: &[R; 2], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        linear_lost(z, e)
    }
    fn bound(&[k, z]: &[f64; 2], _: &[Table]) -> Bound {
        Bound { k, z, linear: true, ..Bound::default() }
    }
}
