//! HRZ: a Hertz contact, one-sided, with a power law and Hunt–Crossley losses.
//!
//! Equation: with the penetration η = d − e (sense "outside") or e − d ("inside"), F = ∓k η^p max(0, 1 + h dη/dt) while η > 0.
//! Parameters: k \[N/m^p\], p (multiple of 1/4; 1.5 for spheres), h [s/m], d \[m\]. Source: Hertz via Bilbao 2009, Hunt 1975.
//! Stability: with method "ca", by rule of thumb T²k p η^(p−1)/m ≤ 1 at the deepest point; from 4 on, with its losses,
//! it is unstable there.
//! "stable" and "stable3d" are passive at any stiffness (`method`). It never pulls. Test: B04.

use super::pow::P;
use super::{ALONG, BETWEEN, Bound, ContactMethod, Law, LawEntry, LawFns, METHOD, PAIRS, Phi, SENSE, Sense, THRESHOLD};
use crate::kind::{Dim, Kind, Need, POSITIVE, Param, Role, Type, Unit};
use crate::method::spring::Power;
use crate::method::{cluster, gradient, quadratised};
use crate::numeric::{Real, Table, quarter_power};
use crate::op::Together;

/// HRZ in the catalog.
pub static KIND: Kind = Kind {
    code: "HRZ",
    title: "Hertz contact",
    equation: "F = -k n^p max(0, 1 + h dn/dt),  n = d - e > 0",
    doc: "The contact of rounded bodies: soft at first touch, hard when pressed, so that loud strokes are brighter. \
          `h` removes energy at each impact and never makes the bodies stick. As with `BUT`, the explicit method adds \
          or removes a little energy at an impact; `method = \"stable\"` does not.",
    source: &["Bilbao 2009", "Hunt 1975"],
    params: &[
        BETWEEN,
        Param::new("k", Type::PowerStiffness { exponent: "p" }, Need::Required, "stiffness in contact"),
        P,
        Param::number(
            "h",
            Unit { symbol: "s/m", dim: Dim::new(-1.0, 0.0, 1.0) },
            POSITIVE,
            Need::Default(0.0),
            "loss at an impact: ratio of damping force to elastic force, per unit of speed",
        ),
        THRESHOLD,
        SENSE,
        PAIRS,
        ALONG,
        METHOD,
    ],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "1 s" }
[MAS]
ball = { m = "5 g", x = "-0.5 mm", v = "1 m/s" }
[HRZ]
strike = { between = ["ball", "bar"], k = "3e6 N/m^1.5", h = "0.2 s/m" }
[SOX]
out = { from = "bar", gain = 1000 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", P = "p", H = "h", D = "d", SENSE = "sense", METHOD = "method");

/// The law of HRZ.
pub static LAW: Law =
    Law::of::<Hrz, 5, 0>("HRZ").or(&[&STABLE, &STABLE3D], |p| match ContactMethod::of(p.get(at::METHOD)?.number()?) {
        ContactMethod::Ca => None,
        ContactMethod::Stable => Some(&STABLE),
        ContactMethod::Stable3d => Some(&STABLE3D),
    });
static STABLE: Law = gradient::law::<Power<f64>>(
    Law::of::<Hrz, 5, 0>("HRZ stable"),
    Together { line: Some(&SHARED), space: Some(&STABLE3D) },
);
static SHARED: Law = cluster::law::<Power<f64>>(Law::of::<Hrz, 5, 0>("HRZ stable, shared"), &STABLE3D);
/// The law of method `stable3d`, also of quadripoles.
pub static STABLE3D: Law = quadratised::law::<Power<f64>>(Law::of::<Hrz, 5, 0>("HRZ stable3d"));

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 4] {
    [
        (LAW.code, LawFns::of::<Hrz, 5, 0>()),
        (STABLE.code, gradient::fns::<R, Power<R>>(LawFns::of::<Hrz, 5, 0>())),
        (SHARED.code, cluster::fns::<R, Power<R>>(LawFns::of::<Hrz, 5, 0>())),
        (STABLE3D.code, stable3d()),
    ]
}

/// Returns the functions over `R` of [`STABLE3D`].
pub fn stable3d<R: Real>() -> LawFns<R> {
    quadratised::fns::<R, Power<R>>(LawFns::of::<Hrz, 5, 0>())
}

/// One-sided power law; coefficients k, 4p, h/T, d, sign of the sense.
pub struct Hrz;

impl Phi<5, 0> for Hrz {
    const CONTACT: bool = true;
    #[inline(always)]
    fn idle<R: Real>(&[_, _, _, d, side]: &[R; 5]) -> (R, R) {
        if side > R::ZERO { (d, R::INFINITY) } else { (R::NEG_INFINITY, d) }
    }
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 5] {
        let n = libm::round(4.0 * p[at::P].unwrap_or(1.5));
        [
            p[at::K].unwrap_or(0.0),
            n,
            p[at::H].unwrap_or(0.0) / tick_dt,
            p[at::D].unwrap_or(0.0),
            Sense::of(p[at::SENSE]).sign(),
        ]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, n, h, d, side]: &[R; 5], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        let eta = side * (d - e);
        if eta > R::ZERO {
            let push = k * quarter_power(eta, n) * (R::of(1.0) - h * side * w);
            if push > R::ZERO { -side * push } else { R::ZERO }
        } else {
            R::ZERO
        }
    }
    #[inline(always)]
    fn potential<R: Real>(&[k, n, _, d, side]: &[R; 5], _: &[R; 0], _: &[Table<R>], e: R) -> R {
        let eta = side * (d - e);
        if eta > R::ZERO { k * quarter_power(eta, n + R::of(4.0)) / (R::of(0.25) * n + R::of(1.0)) } else { R::ZERO }
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 5], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        let elastic = Self::force(&[c[0], c[1], R::ZERO, c[3], c[4]], &mut { *m }, t, e[1], w);
        (Self::force(c, &mut { *m }, t, e[1], w) - elastic) * w
    }
    fn bound(&[k, n, h, ..]: &[f64; 5], _: &[Table]) -> Bound {
        let linear = n == 4.0;
        let (k, power) = if linear { (k, (0.0, 0.0)) } else { (0.0, (k, 0.25 * n)) };
        Bound { k, power, contact: true, hardens: !linear || h != 0.0, ..Bound::default() }
    }
    fn steepest(&[k, n, h, d, side]: &[f64; 5], _: &[Table], [from, to]: [f64; 2]) -> [f64; 2] {
        let (eta, p) = (if side > 0.0 { d - from } else { to - d }.max(0.0), 0.25 * n);
        [k * p * libm::pow(eta, p - 1.0), k * h * libm::pow(eta, p)]
    }
}
