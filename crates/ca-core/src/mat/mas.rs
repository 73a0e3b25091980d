//! MAS: a point mass, with inertia only.
//!
//! Equation: x_{n+1} = 2 x_n − x_{n−1} + (T²/m) f_n. Parameters: m \[kg\] > 0. Source: CMJ 1993.
//! Stability: alone always stable; with links, T²(k + 2z/T)/m summed over them must stay below 4 (docs/numerics.md
//! §1.3).
//! Test: `tests/suite/methods/scheme/mod.rs`.

use super::{Coefs, DX0, MatSpec, V, X};
use crate::kind::{ABOVE_ZERO, Kind, Need, Param, Role, Unit};

/// MAS in the catalog.
pub static KIND: Kind = Kind {
    code: "MAS",
    title: "point mass",
    equation: "x' = 2x - x1 + (T²/m) f",
    doc: "A mass that moves only by the forces on it. The heavier it is, the less it accelerates.",
    source: &["CMJ 1993", "SMC 2007"],
    params: &[Param::number("m", Unit::KILOGRAM, ABOVE_ZERO, Need::Required, "inertia"), X, DX0, V],
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
    role: Role::Mat(&MatSpec { code: "MAS", coefs, fixed: false }),
};

crate::kind::positions!(KIND: M = "m");

fn coefs(p: &[Option<f64>], tick_dt: f64) -> Coefs {
    let m = p[at::M].unwrap_or(1.0);
    Coefs { p: 1.0, q: 0.0, c: tick_dt * tick_dt / m }
}
