//! ATT: an attractor, such as the detent of a knob; also a pluck without hysteresis.
//!
//! Equation: F = k e up to |e| = ρd, then falling linearly to 0 at |e| = d, plus (z/T) w inside d; 0 beyond.
//! Parameters: k \[N/m\], d \[m\] > 0, rho in ]0, 1[, z \[N s/m\]. Source: HSP v2 (contact-detent), LAC 2019 (pluck).
//! Stability: as REF with the steeper of k and kρ/(1 − ρ). Test: conformance suite.

use super::{ALONG, BETWEEN, Bound, ELASTIC_METHOD, Law, LawEntry, LawFns, PAIRS, Phi, by_potential};
use crate::kind::{ABOVE_ZERO, Kind, Need, POSITIVE, Param, Role, Unit};
use crate::method::potential::{self, Numbers, Potential};
use crate::numeric::{Real, Table};

/// ATT in the catalog.
pub static KIND: Kind = Kind {
    code: "ATT",
    title: "attractor (detent)",
    equation: "F = k e for |e| < rho d, then straight to 0 at d",
    doc: "Pulls its ends together while they are closer than `d` and releases them smoothly: the click of a knob, or a \
          pluck that can engage again from either side.",
    source: &["HSP v2", "LAC 2019"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Required, "stiffness near the centre"),
        Param::number("d", Unit::METRE, ABOVE_ZERO, Need::Required, "reach: the force is 0 beyond"),
        Param::number(
            "rho",
            Unit::NONE,
            (1e-6, 0.999_999),
            Need::Default(0.5),
            "elongation of the largest force, as a share of d",
        ),
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity inside d"),
        PAIRS,
        ALONG,
        ELASTIC_METHOD,
    ],
    one_of: &[],
    example: r#"
[CEL]
reed = { m = "1 g", f = "220 Hz", t60 = "1 s" }
[ENX]
finger = {}
[ATT]
pluck = { between = ["reed", "finger"], k = "2 kN/m", d = "2 mm", rho = 0.5, z = "0.02 N s/m" }
[SOX]
out = { from = "reed", gain = 500 }
[gesture]
finger = [[0, 0], [0.3, "8 mm"]]
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", D = "d", RHO = "rho", Z = "z", METHOD = "method");

/// The law of ATT.
pub static LAW: Law = Law::of::<Att, 5, 0>("ATT").or(&[&STABLE], |p| by_potential(p, at::METHOD).then_some(&STABLE));
/// The force falls, so with other such links at the same masses the solver may find none or several solutions.
static STABLE: Law = potential::alone::<Att, 5, 0>("ATT stable", Law::of::<Att, 5, 0>("ATT"), None);

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 2] {
    let law = LawFns::of::<Att, 5, 0>();
    [(LAW.code, law), (STABLE.code, potential::alone_fns::<R, Att, 5, 0>(law))]
}

/// Triangular force; coefficients k, ρd, d, slope of the fall, z/T.
pub struct Att;

impl Phi<5, 0> for Att {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 5] {
        let (k, d, rho) = (p[at::K].unwrap_or(0.0), p[at::D].unwrap_or(1.0), p[at::RHO].unwrap_or(0.5));
        [k, rho * d, d, k * rho / (1.0 - rho), p[at::Z].unwrap_or(0.0) / tick_dt]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, tip, d, fall, z]: &[R; 5], _: &mut [R; 0], _: &[Table<R>], e: R, w: R) -> R {
        let r = e.abs();
        if r < tip {
            k * e + z * w
        } else if r < d {
            (fall * (d - r)).copysign(e) + z * w
        } else {
            R::ZERO
        }
    }
    #[inline(always)]
    fn potential<R: Real>(&[k, tip, d, fall, _]: &[R; 5], _: &[R; 0], _: &[Table<R>], e: R) -> R {
        let r = e.abs();
        let rest = |r: R| R::of(0.5) * fall * (d - r) * (d - r);
        if r < tip {
            R::of(0.5) * k * (r * r - tip * tip) - rest(tip)
        } else if r < d {
            -rest(r)
        } else {
            R::ZERO
        }
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, _, d, _, z]: &[R; 5], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        if e[1].abs() < d { z * w * w } else { R::ZERO }
    }
    fn bound(&[k, _, _, fall, z]: &[f64; 5], _: &[Table]) -> Bound {
        Bound { k: k.max(fall), z, contact: true, ..Bound::default() }
    }
}

impl Potential<5, 0> for Att {
    fn energy<R: Real>(n: &Numbers<R>, tables: &[Table<R>], e: R) -> R {
        Att::potential(n, &[], tables, e)
    }
    fn mean<R: Real>(n: &Numbers<R>, tables: &[Table<R>], a: R, s: R) -> [R; 2] {
        let [k, tip, d, fall, _] = *n;
        let elastic = [k, tip, d, fall, R::ZERO];
        let force = |e: R| Att::force(&elastic, &mut [], tables, e, R::ZERO);
        let (moved, half) = (s - a, R::of(0.5));
        // slope of the piece that contains both elongations
        let slope = |e: R| {
            if e.abs() < tip {
                k
            } else if e.abs() < d {
                -fall
            } else {
                R::ZERO
            }
        };
        let piece = |e: R| (e.abs() < tip, e.abs() < d, e > R::ZERO || e.abs() < tip);
        if piece(a) == piece(s) || moved.abs() <= R::of(1e-9) * tip {
            return [half * (force(a) + force(s)), half * slope(s)];
        }
        let held = |e: R| Att::energy(n, tables, e);
        let mean = (held(s) - held(a)) / moved;
        [mean, (force(s) - mean) / moved]
    }
    fn viscosity<R: Real>(&[_, _, d, _, z]: &[R; 5], _: &[R; 0], _: &[Table<R>], e: R, _: R) -> R {
        if e.abs() < d { z } else { R::ZERO }
    }
    fn most<R: Real>(&[k, tip, ..]: &Numbers<R>, _: &[Table<R>], _: R, _: R) -> R {
        k * tip
    }
}
