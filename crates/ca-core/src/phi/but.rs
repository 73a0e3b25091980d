//! BUT: a buffer, the one-sided contact.
//!
//! Equation: F = k (e − d) + (z/T) w while e < d (sense "outside": keeps the second end above the first) or while e > d
//! (sense "inside": contains it), otherwise 0. It may pull (stick) unless `sticky = false`.
//! Parameters: k \[N/m\], z \[N s/m\], d \[m\]. Source: CMJ 1993, ICMC 2013.
//! Stability: method "ca" is not passive at any stiffness, and from kT²/m + 2zT/m = 4 on it is unstable while
//! compressed. With a = kT²/m ≤ 1 and 0.12 a ≤ zT/m ≤ 1.9 − a one impact on a wall made no energy (docs/numerics.md
//! §3.2). "stable" and "stable3d" are passive at any stiffness (`method`).
//! Test: A17, B05, C01 to C06.

use super::{ALONG, BETWEEN, Bound, ContactMethod, Law, LawEntry, LawFns, METHOD, PAIRS, Phi, SENSE, Sense, THRESHOLD};
use crate::kind::{Kind, Need, POSITIVE, Param, Role, Type, Unit};
use crate::method::spring::Linear;
use crate::method::{cluster, gradient, quadratised};
use crate::numeric::{Real, Table};
use crate::op::Together;

/// BUT in the catalog.
pub static KIND: Kind = Kind {
    code: "BUT",
    title: "buffer (contact)",
    equation: "F = k (e - d) + z de/dt  while e < d (outside) or e > d (inside)",
    doc: "Acts only while its ends are closer than `d`, measured along the axis from the first to the second: it keeps \
          the second above the first. With `sense = \"inside\"` it acts beyond `d` and contains the second instead. \
          Use it for hammers, felt, frets and rattles. It may pull a little as the contact ends, which `sticky = \
          false` prevents. The explicit method adds or removes energy at an impact, more at a higher stiffness; \
          `method = \"stable\"` does not, at any stiffness.",
    source: &["CMJ 1993", "ICMC 2013"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Required, "stiffness in contact"),
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity in contact"),
        THRESHOLD,
        SENSE,
        Param::new("sticky", Type::Flag, Need::Default(1.0), "false: the force never pulls"),
        PAIRS,
        ALONG,
        METHOD,
    ],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "2 g", f = "330 Hz", t60 = "1 s" }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "0.8 m/s" }
[BUT]
strike = { between = ["hammer", "bar"], k = "40 kN/m", z = "0.5 N s/m" }
[SOX]
out = { from = "bar", gain = 1000 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", Z = "z", D = "d", SENSE = "sense", STICKY = "sticky", METHOD = "method");

/// The law of BUT.
pub static LAW: Law =
    Law::of::<But, 5, 0>("BUT").or(&[&STABLE, &STABLE3D], |p| match ContactMethod::of(p.get(at::METHOD)?.number()?) {
        ContactMethod::Ca => None,
        ContactMethod::Stable => Some(&STABLE),
        ContactMethod::Stable3d => Some(&STABLE3D),
    });
static STABLE: Law = gradient::law::<Linear<f64>>(
    Law::of::<But, 5, 0>("BUT stable"),
    Together { line: Some(&SHARED), space: Some(&STABLE3D) },
);
static SHARED: Law = cluster::law::<Linear<f64>>(Law::of::<But, 5, 0>("BUT stable, shared"), &STABLE3D);
/// The law of method `stable3d`, also of quadripoles.
pub static STABLE3D: Law = quadratised::law::<Linear<f64>>(Law::of::<But, 5, 0>("BUT stable3d"));

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 4] {
    [
        (LAW.code, LawFns::of::<But, 5, 0>()),
        (STABLE.code, gradient::fns::<R, Linear<R>>(LawFns::of::<But, 5, 0>())),
        (SHARED.code, cluster::fns::<R, Linear<R>>(LawFns::of::<But, 5, 0>())),
        (STABLE3D.code, stable3d()),
    ]
}

/// Returns the functions over `R` of [`STABLE3D`].
pub fn stable3d<R: Real>() -> LawFns<R> {
    quadratised::fns::<R, Linear<R>>(LawFns::of::<But, 5, 0>())
}

/// One-sided spring and damper; coefficients k, z/T, d, sign of the sense, 1 if clipped.
pub struct But;

impl Phi<5, 0> for But {
    const CONTACT: bool = true;
    #[inline(always)]
    fn idle<R: Real>(&[_, _, d, side, _]: &[R; 5]) -> (R, R) {
        if side > R::ZERO { (d, R::INFINITY) } else { (R::NEG_INFINITY, d) }
    }
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 5] {
        [
            p[at::K].unwrap_or(0.0),
            p[at::Z].unwrap_or(0.0) / tick_dt,
            p[at::D].unwrap_or(0.0),
            Sense::of(p[at::SENSE]).sign(),
            if p[at::STICKY] == Some(0.0) { 1.0 } else { 0.0 },
        ]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, z, d, side, clip]: &[R; 5], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        let g = e - d;
        let f = if side * g < R::ZERO { k * g + z * w } else { R::ZERO };
        if clip != R::ZERO && side * f > R::ZERO { R::ZERO } else { f }
    }
    #[inline(always)]
    fn potential<R: Real>(&[k, _, d, side, _]: &[R; 5], _: &[R; 0], _: &[Table<R>], e: R) -> R {
        let g = e - d;
        if side * g < R::ZERO { R::of(0.5) * k * g * g } else { R::ZERO }
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 5], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        let elastic = Self::force(&[c[0], R::ZERO, c[2], c[3], R::ZERO], &mut { *m }, t, e[1], w);
        (Self::force(c, &mut { *m }, t, e[1], w) - elastic) * w
    }
    fn bound(&[k, z, ..]: &[f64; 5], _: &[Table]) -> Bound {
        Bound { k, z, contact: true, ..Bound::default() }
    }
}
