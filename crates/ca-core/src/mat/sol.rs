//! SOL: ground, a MAT that never moves.
//!
//! Equation: x_{n+1} = x_n. Source: CMJ 1993. Its coefficients are (0, 0, 0), so forces have no effect on it.

use super::{Coefs, DX0, MatSpec, X};
use crate::kind::{Kind, Role};

/// SOL in the catalog.
pub static KIND: Kind = Kind {
    code: "SOL",
    title: "fixed point",
    equation: "x' = x",
    doc: "A point that never moves: the wall a string is tied to, the frame a damper rests on.",
    source: &["CMJ 1993"],
    params: &[X, DX0],
    one_of: &[],
    example: r#"
[SOL]
wall = {}
[MAS]
bob = { m = "1 g", v = "0.5 m/s" }
[REF]
spring = { between = ["wall", "bob"], k = "3 kN/m", z = "4 mN s/m" }
[SOX]
out = { from = "bob", gain = 500 }
"#,
    role: Role::Mat(&MatSpec { code: "SOL", coefs, fixed: true }),
};

fn coefs(_: &[Option<f64>], _: f64) -> Coefs {
    Coefs { p: 0.0, q: 0.0, c: 0.0 }
}
