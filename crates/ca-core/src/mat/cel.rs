//! CEL: a mass with its own spring and damper to its rest position; one damped oscillation.
//!
//! Equation: x_{n+1} = (2 − a − b) x_n + (b − 1) x_{n−1} + (T²/m) f, a = kT²/m, b = zT/m.
//! Parameters: m \[kg\] with k \[N/m\], z \[N s/m\], or with the frequency as heard f \[Hz\] and the decay time t60
//! \[s\].
//! Source: CMJ 1993; retuning as in docs/numerics.md §1.5 (exact inversion of the warping of the scheme). Stability: a
//! + 2b < 4, always true if given by t60 and f below half the sound rate. Test: A04, A05, B02.

use super::{Coefs, DX0, MatSpec, V, X};
use crate::kind::{ABOVE_ZERO, Kind, Need, OneOf, POSITIVE, Param, Role, Unit};
use crate::phi::implicit::{METHOD, THETA};
use crate::tuning::{Method, retune};

/// CEL in the catalog.
pub static KIND: Kind = Kind {
    code: "CEL",
    title: "oscillator cell",
    equation: "x' = (2 - a - b) x + (b - 1) x1 + (T²/m) f,  a = kT²/m, b = zT/m",
    doc: "A mass with a spring and a damper to its rest position. With `f` and `t60` it oscillates at exactly that \
          frequency and decays by 60 dB in exactly that time, at any sound rate. `m` then sets how much it resists a \
          force.",
    source: &["CMJ 1993", "SMC 2007"],
    params: &[
        Param::number("m", Unit::KILOGRAM, ABOVE_ZERO, Need::Required, "inertia"),
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Optional, "stiffness of the spring to the rest position"),
        Param::number(
            "z",
            Unit::VISCOSITY,
            POSITIVE,
            Need::Optional,
            "viscosity of the damper to the rest position; 0 if left out",
        ),
        Param::number(
            "f",
            Unit::HERTZ,
            ABOVE_ZERO,
            Need::Optional,
            "frequency of the oscillation, below half the sound rate",
        ),
        Param::number("t60", Unit::SECOND, ABOVE_ZERO, Need::Optional, "time to decay by 60 dB; no decay if left out"),
        X,
        DX0,
        V,
        METHOD,
        THETA,
    ],
    one_of: &[OneOf { sets: &[&["k", "z"], &["f", "t60"]], required: true }],
    example: r#"
[CEL]
bar = { m = "2 g", f = "440 Hz", t60 = "2 s", dx0 = "0.5 mm" }
[SOX]
out = { from = "bar", gain = 1000 }
"#,
    role: Role::Mat(&MatSpec { code: "CEL", coefs, fixed: false }),
};

crate::kind::positions!(KIND: M = "m", K = "k", Z = "z", F = "f", T60 = "t60", METHOD = "method", THETA = "theta");

fn coefs(p: &[Option<f64>], tick_dt: f64) -> Coefs {
    let m = p[at::M].unwrap_or(1.0);
    let c = tick_dt * tick_dt / m;
    if let Some(f) = p[at::F] {
        let (a, b) = retune(f, p[at::T60].unwrap_or(f64::INFINITY), tick_dt);
        return Coefs { p: 1.0 - b, q: -a, c };
    }
    let (k, z) = (p[at::K].unwrap_or(0.0), p[at::Z].unwrap_or(0.0));
    if let Some(theta) = Method::of(p[at::METHOD]).theta(p[at::THETA]) {
        // the implicit part is inertia (docs/numerics.md §1.3, eq. 1′): an explicit cell of this mass is the same
        // scheme
        let c = 1.0 / (m / (tick_dt * tick_dt) + theta * k + 0.5 * z / tick_dt);
        return Coefs { p: 1.0 - z / tick_dt * c, q: -k * c, c };
    }
    Coefs { p: 1.0 - z * tick_dt / m, q: -k * c, c }
}
