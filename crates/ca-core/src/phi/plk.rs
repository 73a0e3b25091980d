//! PLK: a plectrum, with true hysteresis.
//!
//! Equation: while engaged, F = k e + (z/T) w, with the elongation e (second end minus first \[m\]), its change w in
//! the last tick \[m\] and the tick T \[s\]. F > 0 pulls the ends together. It releases when |e| ≥ d, and engages
//! again when e changes sign. One-sided, it engages only when e rises through 0 (up) or falls through 0 (down), and
//! releases when e returns to 0. Parameters: k \[N/m\], z \[N s/m\], d \[m\] > 0. Source: HSP v2 (contact-pluck); for
//! the energy docs/numerics.md §2.2: the energy k e²/2 stored at release reaches no end, so the ledger enters it as
//! heat. Stability: as REF while engaged, but judged as a contact. Test: `tests/suite/laws/pluck.rs`.

use super::{
    ALONG, BETWEEN, Bound, ELASTIC_METHOD, Law, LawEntry, LawFns, PAIRS, Phi, by_potential, linear_lost, linear_stored,
};
use crate::kind::{ABOVE_ZERO, Kind, Need, POSITIVE, Param, Role, Type, Unit};
use crate::method::potential::{self, Numbers, Potential};
use crate::numeric::{NONE, Real, Table};

crate::choice::choice! {
    /// Direction of motion in which it plucks.
    pub enum Side {
        /// both directions
        Both = "both",
        /// when the second end rises past the first
        Up = "up",
        /// when it falls past it
        Down = "down",
    }
}

impl Side {
    /// Returns the sign of the elongation at which it holds, or 0 for both.
    fn sign(self) -> f64 {
        match self {
            Side::Both => 0.0,
            Side::Up => 1.0,
            Side::Down => -1.0,
        }
    }
}

/// PLK in the catalog.
pub static KIND: Kind = Kind {
    code: "PLK",
    title: "pluck with hysteresis",
    equation: "F = k e + z de/dt while engaged; releases at |e| >= d, engages when e changes sign",
    doc: "Acts as a spring until its elongation reaches `d`, then releases. It engages again only when the plectrum \
          has come back through the string, so each passage plays one note, as long as the ends move less than `d` \
          in a tick (48 m/s for d = 1 mm at 48 kHz); near that speed it is quieter. With \
          `side = \"up\"` it passes freely on its way down. With `engaged = false` it engages at its first passage \
          and not at load.",
    source: &["HSP v2"],
    params: &[
        BETWEEN,
        Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Required, "stiffness while engaged"),
        Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Default(0.0), "viscosity while engaged"),
        Param::number("d", Unit::METRE, ABOVE_ZERO, Need::Required, "elongation at which it releases"),
        Param::new(
            "side",
            Type::Choice(Side::WORDS),
            Need::Default(0.0),
            "direction of the second end in which it plucks",
        ),
        Param::new(
            "engaged",
            Type::Flag,
            Need::Default(1.0),
            "whether it is engaged at load, if its ends are closer than d",
        ),
        PAIRS,
        ALONG,
        ELASTIC_METHOD,
    ],
    one_of: &[],
    example: r#"
[CEL]
reed = { m = "1 g", f = "220 Hz", t60 = "1 s" }
[ENX]
plectrum = {}
[PLK]
pluck = { between = ["reed", "plectrum"], k = "2 kN/m", z = "0.05 N s/m", d = "1 mm" }
[SOX]
out = { from = "reed", gain = 500 }
[gesture]
plectrum = [[0, 0], [0.3, "3 mm"], [0.6, "3 mm"], [1, "-3 mm"]]
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: K = "k", Z = "z", D = "d", SIDE = "side", ENGAGED = "engaged", METHOD = "method");

/// The law of PLK.
pub static LAW: Law = Law::of::<Plk, 5, 3>("PLK").or(&[&STABLE], |p| by_potential(p, at::METHOD).then_some(&STABLE));
static STABLE: Law = potential::alone::<Plk, 5, 4>("PLK stable", Law::of::<Plk, 5, 3>("PLK"), Some(&SHARED));
static SHARED: Law = potential::shared::<Plk, 5, 4>("PLK stable, shared", Law::of::<Plk, 5, 3>("PLK"));

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 3] {
    let law = LawFns::of::<Plk, 5, 3>();
    [
        (LAW.code, law),
        (STABLE.code, potential::alone_fns::<R, Plk, 5, 4>(law)),
        (SHARED.code, potential::shared_fns::<R, Plk, 5, 4>(law)),
    ]
}

/// Coefficients: k, z/T, d, the sign of the side, and 1 if it is engaged at load. Memory of the explicit method: 1
/// while engaged, the last elongation, and the energy lost in this tick. The method `stable` has another memory, see
/// `Potential`.
pub struct Plk;

impl Phi<5, 3> for Plk {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 5] {
        let side = Side::of(p[at::SIDE]).sign();
        let engaged = if p[at::ENGAGED] == Some(0.0) { 0.0 } else { 1.0 };
        [p[at::K].unwrap_or(0.0), p[at::Z].unwrap_or(0.0) / tick_dt, p[at::D].unwrap_or(NONE), side, engaged]
    }
    fn start<R: Real>(&[_, _, d, side, engaged]: &[R; 5], e: R) -> [R; 3] {
        [if e.abs() < d && side * e >= R::ZERO { engaged } else { R::ZERO }, e, R::ZERO]
    }
    #[inline(always)]
    fn force<R: Real>(&[k, z, d, side, _]: &[R; 5], mem: &mut [R; 3], _: &[Table<R>], e: R, w: R) -> R {
        let [engaged, last, released] = mem;
        *released = R::ZERO;
        if *engaged != R::ZERO {
            if e.abs() >= d {
                *engaged = R::ZERO;
                *released = R::of(0.5) * k * e * e;
            } else if side * e < R::ZERO {
                // e is within a tick of 0, so almost no energy is stored; it is not entered as heat
                *engaged = R::ZERO;
            }
        } else if e.abs() < d {
            // the elongation changed sign, or went from 0 to the side on which it holds
            let (rises, falls) = (*last <= R::ZERO && e >= R::ZERO, *last >= R::ZERO && e <= R::ZERO);
            if (rises && side >= R::ZERO) || (falls && side <= R::ZERO) {
                *engaged = R::of(1.0);
            }
        }
        *last = e;
        if *engaged == R::ZERO { R::ZERO } else { k * e + z * w }
    }
    #[inline(always)]
    fn stored<R: Real>(&[k, z, ..]: &[R; 5], mem: &[R; 3], _: &[Table<R>], e0: R, e1: R) -> R {
        if mem[0] == R::ZERO { R::ZERO } else { linear_stored(k, z, e0, e1) }
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, z, ..]: &[R; 5], mem: &[R; 3], _: &[Table<R>], e: [R; 3]) -> R {
        if mem[0] == R::ZERO { mem[2] } else { linear_lost(z, e) }
    }
    fn bound(&[k, z, ..]: &[f64; 5], _: &[Table]) -> Bound {
        Bound { k, z, contact: true, ..Bound::default() }
    }
}

/// Memory of the method `stable`: 1 while engaged, the last elongation, and the two bounds of the slack.
///
/// It engages between two ticks. To make no energy, it must store nothing at either of them. So the elongations at
/// these ticks bound a slack, a range in which the force is 0. Once the motion has left the slack on one side, the
/// slack shrinks to the bound on that side.
impl Potential<5, 4> for Plk {
    fn at_load<R: Real>(c: &[R; 5], e: R) -> [R; 4] {
        let [engaged, last, _] = Plk::start(c, e);
        [engaged, last, R::ZERO, R::ZERO]
    }
    fn begin<R: Real>(c: &[R; 5], mem: &mut [R; 4], e: R, w: R) -> R {
        let held = Plk::numbers(c, mem);
        let before = e - w;
        let mut hysteresis = [mem[0], mem[1], R::ZERO];
        Plk::force(c, &mut hysteresis, &[], e, w);
        let [engaged, last, _] = hysteresis;
        let [held_before, low, high] = [mem[0], mem[2], mem[3]];
        let [from, to] = [before.min(e), before.max(e)];
        let slack = match () {
            () if held_before == R::ZERO => [from, to],
            () if from >= high => [high; 2],
            () if to <= low => [low; 2],
            () => [low, high],
        };
        *mem = [engaged, last, slack[0], slack[1]];
        let gives_up = held_before != R::ZERO && engaged == R::ZERO;
        if gives_up { R::of(0.5) * (Plk::energy(&held, &[], before) + Plk::energy(&held, &[], e)) } else { R::ZERO }
    }
    fn numbers<R: Real>(&[k, ..]: &[R; 5], &[engaged, _, low, high]: &[R; 4]) -> Numbers<R> {
        [if engaged == R::ZERO { R::ZERO } else { k }, low, high, R::ZERO, R::ZERO]
    }
    fn energy<R: Real>(&[k, low, high, ..]: &Numbers<R>, _: &[Table<R>], e: R) -> R {
        let out = beyond(low, high, e);
        R::of(0.5) * k * out * out
    }
    fn mean<R: Real>(&[k, low, high, ..]: &Numbers<R>, _: &[Table<R>], a: R, s: R) -> [R; 2] {
        let [from, to] = [a, s].map(|e| beyond(low, high, e));
        let half = R::of(0.5) * k;
        let within = |e: R| e > low && e < high;
        // without slack, or on one side of it
        if low == high || (from > R::ZERO && to > R::ZERO) || (from < R::ZERO && to < R::ZERO) {
            return [half * (from + to), half];
        }
        if s == a || within(a) && within(s) {
            return [R::ZERO; 2];
        }
        let mean = half * (to * to - from * from) / (s - a);
        [mean, ((k * to - mean) / (s - a)).max(R::ZERO)]
    }
    fn viscosity<R: Real>(&[_, z, ..]: &[R; 5], &[engaged, ..]: &[R; 4], _: &[Table<R>], _: R, _: R) -> R {
        if engaged == R::ZERO { R::ZERO } else { z }
    }
}

fn beyond<R: Real>(low: R, high: R, e: R) -> R {
    if e > high {
        e - high
    } else if e < low {
        e - low
    } else {
        R::ZERO
    }
}
