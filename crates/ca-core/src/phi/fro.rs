//! FRO: a damper.
//!
//! Equation: F = (z/T) w. Parameters: z \[N s/m\] ≥ 0. Source: CMJ 1993. Stability: 2zT(1/m₁ + 1/m₂) < 4 for one link;
//! the backward difference acts as a centred damper and a negative mass −zT/2 (docs/numerics.md §1.4). Test: A04, A10.

use super::implicit::{METHOD, THETA};
use super::{ALONG, BETWEEN, Bound, L0, Law, LawEntry, LawFns, PAIRS, Phi, SOFTEN, linear_lost, linear_stored};
use crate::kind::{Kind, Need, POSITIVE, Param, Role, Unit};
use crate::law::Number;
use crate::numeric::{Real, Table};

/// FRO in the catalog.
pub static KIND: Kind = Kind {
    code: "FRO",
    title: "damper",
    equation: "F = z de/dt",
    doc: "Resists the relative speed of its ends, and turns motion into heat.",
    source: &["CMJ 1993"],
    params: &[
        BETWEEN,
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Required, "viscosity"),
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
[CEL]
bar = { m = "2 g", f = "330 Hz", dx0 = "0.5 mm" }
[FRO]
felt = { between = ["wall", "bar"], z = "10 mN s/m" }
[SOX]
out = { from = "bar", gain = 1000 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: Z = "z");

/// The law of FRO. REF without stiffness runs the same functions.
pub static LAW: Law = Law::of::<Fro, 1, 0>("FRO");

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 1] {
    [(LAW.code, LawFns::of::<Fro, 1, 0>())]
}

/// F = (z/T) w
pub struct Fro;

impl Phi<1, 0> for Fro {
    const LINEAR: bool = true;
    const WIDE: bool = true;
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 1] {
        [p[at::Z].unwrap_or(0.0) / tick_dt]
    }
    #[inline(always)]
    fn linear<N: Number>(&[z]: &[N; 1], _e: N, w: N) -> N {
        z * w
    }
    #[inline(always)]
    fn force<R: Real>(c: &[R; 1], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        Self::linear(c, e, w)
    }
    #[inline(always)]
    fn stored<R: Real>(&[z]: &[R; 1], _: &[R; 0], _: &[Table<R>], e0: R, e1: R) -> R {
        linear_stored(R::ZERO, z, e0, e1)
    }
    #[inline(always)]
    fn lost<R: Real>(&[z]: &[R; 1], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        linear_lost(z, e)
    }
    fn bound(&[z]: &[f64; 1], _: &[Table]) -> Bound {
        Bound { z, linear: true, ..Bound::default() }
    }
}
