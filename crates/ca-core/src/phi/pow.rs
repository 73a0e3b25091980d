//! POW: a spring with a power law, two-sided.
//!
//! Equation: F = k e + q sgn(e)|e|^p + (z/T) w. Parameters: k \[N/m\], q \[N/m^p\], p (a multiple of 1/4 from 1 to 5, so
//! that the tick needs only products and square roots), z \[N s/m\]. Source: SMC 2019 (nlSpring2 is p = 2).
//! Stability: rule of thumb on the tangent, as CUB. Test: conformance suite.

use super::{
    ALONG, BETWEEN, Bound, ELASTIC_METHOD, L0, Law, LawEntry, LawFns, PAIRS, Phi, SOFTEN, by_potential, linear_lost,
    linear_stored,
};
use crate::kind::{Kind, Need, POSITIVE, Param, Role, Type, Unit};
use crate::method::potential::{self, Numbers, Potential};
use crate::numeric::{Real, Table, quarter_mean, quarter_power};

/// Parameter `p`: exponent of a power law.
pub const P: Param = Param::number("p", Unit::NONE, (1.0, 5.0), Need::Default(1.5), "exponent, a multiple of 1/4");

/// POW in the catalog.
pub static KIND: Kind = Kind {
    code: "POW",
    title: "power-law spring",
    equation: "F = k e + q sgn(e) |e|^p + z de/dt",
    doc: "A spring that is soft near rest and stiffer further out (p > 1), the same in both directions.",
    source: &["SMC 2019"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Default(0.0), "linear stiffness"),
        Param::new("q", Type::PowerStiffness { exponent: "p" }, Need::Required, "stiffness of the power law"),
        P,
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
[POW]
spring = { between = ["wall", "bob"], k = "1 kN/m", q = "3e6 N/m^2", p = 2, z = "3 mN s/m" }
[SOX]
out = { from = "bob", gain = 500 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", Q = "q", P = "p", Z = "z", METHOD = "method");

/// The law of POW.
pub static LAW: Law = Law::of::<Pow, 4, 0>("POW").or(&[&STABLE], |p| by_potential(p, at::METHOD).then_some(&STABLE));
static STABLE: Law = potential::alone::<Pow, 4, 0>("POW stable", Law::of::<Pow, 4, 0>("POW"), Some(&SHARED));
static SHARED: Law = potential::shared::<Pow, 4, 0>("POW stable, shared", Law::of::<Pow, 4, 0>("POW"));

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 3] {
    let law = LawFns::of::<Pow, 4, 0>();
    [
        (LAW.code, law),
        (STABLE.code, potential::alone_fns::<R, Pow, 4, 0>(law)),
        (SHARED.code, potential::shared_fns::<R, Pow, 4, 0>(law)),
    ]
}

/// F = k e + q sgn(e)|e|^(n/4) + (z/T) w; coefficients k, q, n, z/T.
pub struct Pow;

impl Phi<4, 0> for Pow {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 4] {
        let n = libm::round(4.0 * p[at::P].unwrap_or(1.5));
        [p[at::K].unwrap_or(0.0), p[at::Q].unwrap_or(0.0), n, p[at::Z].unwrap_or(0.0) / tick_dt]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, q, n, z]: &[R; 4], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        k * e + q * quarter_power(e.abs(), n).copysign(e) + z * w
    }
    #[inline(always)]
    fn stored<R: Real>(&[k, q, n, z]: &[R; 4], _: &[R; 0], _: &[Table<R>], e0: R, e1: R) -> R {
        linear_stored(k, z, e0, e1) + R::of(0.5) * (power(q, n, e0) + power(q, n, e1))
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, _, _, z]: &[R; 4], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        linear_lost(z, e)
    }
    fn bound(&[k, q, n, z]: &[f64; 4], _: &[Table]) -> Bound {
        let linear = n == 4.0;
        Bound { k: if linear { k + q } else { k }, z, hardens: !linear, ..Bound::default() }
    }
    fn steepest(&[k, q, n, z]: &[f64; 4], _: &[Table], [from, to]: [f64; 2]) -> [f64; 2] {
        let p = 0.25 * n;
        [k + p * q * libm::pow(to.max(-from), p - 1.0), z]
    }
}

#[inline(always)]
fn power<R: Real>(q: R, n: R, e: R) -> R {
    q * quarter_power(e.abs(), n + R::of(4.0)) / (R::of(0.25) * n + R::of(1.0))
}

impl Potential<4, 0> for Pow {
    fn energy<R: Real>(&[k, q, n, ..]: &Numbers<R>, _: &[Table<R>], e: R) -> R {
        R::of(0.5) * k * e * e + power(q, n, e)
    }
    fn mean<R: Real>(&[k, q, n, ..]: &Numbers<R>, _: &[Table<R>], a: R, s: R) -> [R; 2] {
        let (moved, far, p) = (s - a, s.abs().max(a.abs()), R::of(0.25) * n);
        let force = |e: R| q * quarter_power(e.abs(), n).copysign(e);
        let mean = if a * s > R::ZERO {
            q / (p + R::of(1.0)) * quarter_mean(s.abs(), a.abs(), n + R::of(4.0)).copysign(s)
        } else if moved == R::ZERO {
            R::ZERO
        } else {
            (power(q, n, s) - power(q, n, a)) / moved
        };
        // near `a` the difference of forces is all rounding
        let rise = if moved.abs() <= R::of(1e-6) * far {
            R::of(0.5) * p * q * quarter_power(far, n - R::of(4.0))
        } else {
            ((force(s) - mean) / moved).max(R::ZERO)
        };
        let half = R::of(0.5) * k;
        [half * (a + s) + mean, half + rise]
    }
    fn viscosity<R: Real>(&[_, _, _, z]: &[R; 4], _: &[R; 0], _: &[Table<R>], _: R, _: R) -> R {
        z
    }
}
