//! CUB: a hardening spring.
//!
//! Equation: F = k e + k3 e³ + (z/T) w. Parameters: k \[N/m\], k3 \[N/m³\] ≥ 0, z \[N s/m\]. Source: SMC 2019 (nlSpring3).
//! Stability: the tangent T²(k + 3 k3 e²)/m must stay below about 1 (docs/numerics.md §3.4). Test: B03.

use super::{
    ALONG, BETWEEN, Bound, ELASTIC_METHOD, L0, Law, LawEntry, LawFns, PAIRS, Phi, SOFTEN, by_potential, linear_lost,
    linear_stored,
};
use crate::kind::{Kind, Need, POSITIVE, Param, Role, Unit};
use crate::method::potential::{self, Numbers, Potential};
use crate::numeric::{Real, Table};

/// CUB in the catalog.
pub static KIND: Kind = Kind {
    code: "CUB",
    title: "hardening spring (cubic)",
    equation: "F = k e + k3 e³ + z de/dt",
    doc: "A spring that becomes stiffer as it is stretched: the pitch rises with loudness, and partials appear that a \
          linear spring does not have.",
    source: &["SMC 2019"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Default(0.0), "stiffness at rest"),
        Param::number("k3", Unit::CUBIC, POSITIVE, Need::Required, "cubic stiffness"),
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity"),
        L0,
        PAIRS,
        ALONG,
        SOFTEN,
        ELASTIC_METHOD,
    ],
    one_of: &[],
    example: r#"
[SOL]
wall = {}
[MAS]
bob = { m = "1 g", dx0 = "1 mm" }
[CUB]
spring = { between = ["wall", "bob"], k = "1.5 kN/m", k3 = "1e10 N/m^3", z = "3 mN s/m" }
[SOX]
out = { from = "bob", gain = 500 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", K3 = "k3", Z = "z", METHOD = "method");

/// The law of CUB.
pub static LAW: Law = Law::of::<Cub, 3, 0>("CUB").or(&[&STABLE], |p| by_potential(p, at::METHOD).then_some(&STABLE));
static STABLE: Law = potential::alone::<Cub, 3, 0>("CUB stable", Law::of::<Cub, 3, 0>("CUB"), Some(&SHARED));
static SHARED: Law = potential::shared::<Cub, 3, 0>("CUB stable, shared", Law::of::<Cub, 3, 0>("CUB"));

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 3] {
    let law = LawFns::of::<Cub, 3, 0>();
    [
        (LAW.code, law),
        (STABLE.code, potential::alone_fns::<R, Cub, 3, 0>(law)),
        (SHARED.code, potential::shared_fns::<R, Cub, 3, 0>(law)),
    ]
}

/// F = k e + k3 e³ + (z/T) w
pub struct Cub;

impl Phi<3, 0> for Cub {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 3] {
        [p[at::K].unwrap_or(0.0), p[at::K3].unwrap_or(0.0), p[at::Z].unwrap_or(0.0) / tick_dt]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, k3, z]: &[R; 3], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        (k + k3 * e * e) * e + z * w
    }
    #[inline(always)]
    fn stored<R: Real>(&[k, k3, z]: &[R; 3], _: &[R; 0], _: &[Table<R>], e0: R, e1: R) -> R {
        let quartic = |e: R| R::of(0.25) * k3 * e * e * e * e;
        linear_stored(k, z, e0, e1) + R::of(0.5) * (quartic(e0) + quartic(e1))
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, _, z]: &[R; 3], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        linear_lost(z, e)
    }
    fn bound(&[k, _, z]: &[f64; 3], _: &[Table]) -> Bound {
        Bound { k, z, hardens: true, ..Bound::default() }
    }
    fn steepest(&[k, k3, z]: &[f64; 3], _: &[Table], [from, to]: [f64; 2]) -> [f64; 2] {
        let far = to.max(-from);
        [k + 3.0 * k3 * far * far, z]
    }
}

impl Potential<3, 0> for Cub {
    fn energy<R: Real>(&[k, k3, ..]: &Numbers<R>, _: &[Table<R>], e: R) -> R {
        R::of(0.5) * e * e * (k + R::of(0.5) * k3 * e * e)
    }
    fn mean<R: Real>(&[k, k3, ..]: &Numbers<R>, _: &[Table<R>], a: R, s: R) -> [R; 2] {
        let (sum, squares, half) = (a + s, a * a + s * s, R::of(0.5));
        [half * sum * (k + half * k3 * squares), half * (k + k3 * (half * squares + sum * s))]
    }
    fn viscosity<R: Real>(&[_, _, z]: &[R; 3], _: &[R; 0], _: &[Table<R>], _: R, _: R) -> R {
        z
    }
}
