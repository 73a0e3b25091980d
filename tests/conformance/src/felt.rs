//! A law outside the catalog: felt, a contact with hysteresis, nine coefficients and memory.
//!
//! With it the conformance suite runs a law that differs from all bundled ones in each of these, added as another crate
//! would add it. The law is passive by construction. Pressed deeper than ever in this contact, it follows the loading
//! curve L(n), otherwise a softer curve that ends there; the difference is heat.
//!
//! Equation: n = d − e (sense "outside"), L = k n + q max(n − b, 0), m = largest n since touch; F = −L (r + (1 − r)
//! n/m) + z w while n > 0, with `z` while closing and `zo` while opening.

use ca_core::internal::phi::{ALONG, PAIRS};
use ca_core::{ANY, BETWEEN, Bound, Kind, Law, Need, POSITIVE, Param, Phi, Real, Role, Table, Type, Unit};

/// Its catalog record.
pub static KIND: Kind = Kind {
    code: "FELT",
    title: "felt (contact with hysteresis)",
    equation: "F = -L(n) (r + (1 - r) n/m) + z de/dt  while n = d - e > 0",
    doc: "Gives back less than it took: a part of the work of the first compression is heat.",
    source: &["Bilbao 2009"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Required, "stiffness when first pressed"),
        Param::number("q", Unit::STIFFNESS, POSITIVE, Need::Default(0.0), "what is added to it beyond `b`"),
        Param::number("b", Unit::METRE, POSITIVE, Need::Default(1e-3), "depth at which it becomes stiffer"),
        Param::number("r", Unit::NONE, (0.0, 1.0), Need::Default(0.5), "part of the force that is the same both ways"),
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity while closing"),
        Param::number("zo", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity while opening"),
        Param::number("d", Unit::METRE, ANY, Need::Default(0.0), "threshold of the distance second − first"),
        Param::new("sense", Type::Choice(&["outside", "inside"]), Need::Default(0.0), "keeps apart, or contains"),
        Param::new("sticky", Type::Flag, Need::Default(1.0), "false clips the pull while letting go"),
        PAIRS,
        ALONG,
    ],
    one_of: &[],
    example: r#"
[CEL]
bar = { m = "2 g", f = "330 Hz", t60 = "1 s" }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "0.8 m/s" }
[FELT]
strike = { between = ["hammer", "bar"], k = "40 kN/m", q = "20 kN/m", b = "0.2 mm", z = "0.5 N s/m" }
[SOX]
out = { from = "bar", gain = 1000 }
"#,
    role: Role::Lia(&LAW),
};

static LAW: Law = Law::of::<Felt, 9, 2>("FELT");

/// Coefficients k, q, b, r, z/T, zo/T, d, sign of the sense, 1 if clipped. Memory: largest penetration in this contact,
/// and heat of the last tick from hysteresis.
struct Felt;

/// Integrals of the loading curve L from 0 to `n`: of L, and of L times depth.
fn areas<R: Real>(&[k, q, b, ..]: &[R; 9], n: R) -> [R; 2] {
    let o = (n - b).max(R::ZERO);
    [R::of(0.5) * (k * n * n + q * o * o), k * n * n * n / R::of(3.0) + q * o * o * (o / R::of(3.0) + R::of(0.5) * b)]
}

/// Energy not returned after a compression to the depth `m`.
fn kept<R: Real>(c: &[R; 9], m: R) -> R {
    let [work, moment] = areas(c, m);
    if m > R::ZERO { (R::of(1.0) - c[3]) * (work - moment / m) } else { R::ZERO }
}

/// Penetration, 0 if not touching.
fn depth<R: Real>(c: &[R; 9], e: R) -> R {
    (c[7] * (c[6] - e)).max(R::ZERO)
}

impl Phi<9, 2> for Felt {
    const CONTACT: bool = true;
    fn idle<R: Real>(&[_, _, _, _, _, _, d, side, _]: &[R; 9]) -> (R, R) {
        if side > R::ZERO { (d, Real::INFINITY) } else { (Real::NEG_INFINITY, d) }
    }
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 9] {
        let at = |i: usize| p[i].unwrap_or(0.0);
        let side = if p[8] == Some(1.0) { -1.0 } else { 1.0 };
        let clip = if p[9] == Some(0.0) { 1.0 } else { 0.0 };
        [at(1), at(2), at(3), at(4), at(5) / tick_dt, at(6) / tick_dt, at(7), side, clip]
    }
    fn start<R: Real>(c: &[R; 9], e: R) -> [R; 2] {
        [depth(c, e), R::ZERO]
    }
    fn force<R: Real>(c: &[R; 9], mem: &mut [R; 2], _: &[Table<R>], e: R, w: R) -> R {
        let &[k, q, b, r, closing, opening, _, side, clip] = c;
        let n = depth(c, e);
        let before = mem[0];
        // after release the memory is as before the blow
        let m = if n > R::ZERO { before.max(n) } else { R::ZERO };
        *mem = [m, (kept(c, m) - kept(c, before)).max(R::ZERO)];
        if n == R::ZERO {
            return R::ZERO;
        }
        let push = (k * n + q * (n - b).max(R::ZERO)) * (r + (R::of(1.0) - r) * n / m);
        let f = -side * push + if side * w < R::ZERO { closing } else { opening } * w;
        if clip != R::ZERO && side * f > R::ZERO { R::ZERO } else { f }
    }
    fn potential<R: Real>(c: &[R; 9], mem: &[R; 2], _: &[Table<R>], e: R) -> R {
        let n = depth(c, e);
        let [work, moment] = areas(c, n);
        if n > R::ZERO { c[3] * work + (R::of(1.0) - c[3]) * moment / n.max(mem[0]) } else { R::ZERO }
    }
    fn lost<R: Real>(c: &[R; 9], mem: &[R; 2], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        let elastic = &[c[0], c[1], c[2], c[3], R::ZERO, R::ZERO, c[6], c[7], R::ZERO];
        let viscous = Self::force(c, &mut { *mem }, t, e[1], w) - Self::force(elastic, &mut { *mem }, t, e[1], w);
        mem[1] + viscous * w
    }
    fn bound(&[k, q, _, r, closing, opening, ..]: &[f64; 9], _: &[Table]) -> Bound {
        // on unloading, the curve ends with up to 2 − r times the slope of the loading curve
        Bound { k: (k + q) * (2.0 - r), z: closing.max(opening), contact: true, ..Bound::default() }
    }
}
