//! BOW: dry friction against relative speed, as of a bow on a string.
//!
//! Equation: F = f g(v), v = de/dt, with the curve
//!   smooth     g = u exp(½ − u²/2), u = v/v0 (peak 1 at v0; from a table of 4097 points, within 2e-6)
//!   piecewise  rises to 1 at v0, falls to fd/f at v1, stays there
//!   coulomb    v/v0 clipped to ±1: sliding friction with a viscous hold below v0
//!   table      the points of `points` \[m/s, N\]
//! Parameters: f \[N\], v0 \[m/s\], v1 \[m/s\], fd \[N\]. Source: ICMC 2013 (LNL friction), LAC 2019 (nlBow), HSP v2.
//! With `curve = "coulomb"` and `method = "set-valued"` the ends do not slip while the force that holds them is below f;
//! once they slip, the friction is fd.
//! Stability: the slope f/v0 counts as a viscosity. With method "ca", sticking is accurate for slope·T/m < 1.5
//! (docs/numerics.md §3.5). The law adds no energy if the force opposes the motion, which only a `table` can violate.
//! With `method` "secant" or "newton" this holds for any slope. Test: B07.

use super::{ALONG, BETWEEN, Bound, Law, LawEntry, LawFns, PAIRS, ParamBinding, Phi, lnl};
use crate::kind::{ABOVE_ZERO, Kind, Need, POSITIVE, Param, Role, Type, Unit};
use crate::method::coulomb;
use crate::method::friction::{self, Curve};
use crate::numeric::{NONE, Real, Table};
use alloc::vec::Vec;

crate::choice::choice! {
    /// Shape of the curve of force over speed.
    pub enum CurveShape {
        /// u exp(½ − u²/2)
        Smooth = "smooth",
        /// piecewise linear: rises, falls, stays constant
        Piecewise = "piecewise",
        /// rises, then stays constant
        Coulomb = "coulomb",
        /// given by points
        Table = "table",
    }
}
crate::choice::choice! {
    /// Method for the friction force.
    pub enum FrictionMethod {
        /// explicit
        Ca = "ca",
        /// secant: slope from the origin at the speed of the tick before
        Secant = "secant",
        /// Newton's method
        Newton = "newton",
        /// Coulomb's law itself: any force up to the largest holds
        SetValued = "set-valued",
    }
}

/// BOW in the catalog.
pub static KIND: Kind = Kind {
    code: "BOW",
    title: "bow friction",
    equation: "F = f g(v / v0),  v = de/dt",
    doc: "Dry friction, with the stick–slip motion of a bow: the ends stick while they move together and slip \
          otherwise. Connect the bow (an ENX or TGR) to a point of the string and move it. With light masses and a \
          large force the explicit law rings where it should stick; `method = \"newton\"` does not.",
    source: &["ICMC 2013", "LAC 2019", "HSP v2"],
    params: &[
        BETWEEN,
        Param::new("curve", Type::Choice(CurveShape::WORDS), Need::Default(0.0), "shape of the force over speed"),
        Param::number("f", Unit::NEWTON, POSITIVE, Need::Optional, "largest friction force"),
        Param::number("v0", Unit::SPEED, ABOVE_ZERO, Need::Optional, "speed at which the force is largest"),
        Param::number(
            "v1",
            Unit::SPEED,
            ABOVE_ZERO,
            Need::Optional,
            "piecewise: speed at which the fall ends; 3 v0 if left out",
        ),
        Param::number(
            "fd",
            Unit::NEWTON,
            POSITIVE,
            Need::Optional,
            "sliding force; if left out, 0 for piecewise and `f` for set-valued",
        ),
        Param::new("points", Type::Points { x: Unit::SPEED, y: Unit::NEWTON }, Need::Optional, "table: [speed, force]"),
        PAIRS,
        ALONG,
        Param::new(
            "method",
            Type::Choice(FrictionMethod::WORDS),
            Need::Default(0.0),
            "ca: explicit; secant: passive at any slope; newton: passive too, and more exact, but uses secant where \
             the slope is too steep or the place is shared; set-valued, for the curve coulomb: sticking ends do not \
             slip at all",
        ),
    ],
    one_of: &[crate::kind::OneOf { sets: &[&["f", "v0", "v1", "fd"], &["points"]], required: true }],
    example: r#"
[CEL]
bar = { m = "1 g", f = "220 Hz", t60 = "0.5 s" }
[ENX]
bow = {}
[BOW]
rub = { between = ["bar", "bow"], curve = "smooth", f = "0.3 N", v0 = "50 mm/s" }
[SOX]
out = { from = "bar", gain = 2000 }
[gesture]
bow = [[0, 0], [1, "0.2 m"]]
"#,
    role: Role::Lia(&SMOOTH),
};

crate::kind::positions!(KIND: CURVE = "curve", F = "f", V0 = "v0", V1 = "v1", FD = "fd", POINTS = "points", METHOD = "method");

/// The law of BOW, replaced for another curve or method.
pub static SMOOTH: Law = Law::of::<Smooth, 3, 0>("BOW smooth").with_table(bell).or(OTHERS, |p| {
    let number = |i: usize| p.get(i).and_then(|p: &ParamBinding| p.number());
    let law = LAWS[CurveShape::of(number(at::CURVE)?) as usize][FrictionMethod::of(number(at::METHOD)) as usize];
    (!core::ptr::eq(law, &raw const SMOOTH)).then_some(law)
});
/// Law with `curve = "piecewise"`.
pub static PIECEWISE: Law = Law::of::<Piecewise, 5, 0>("BOW piecewise");
/// Law with `curve = "coulomb"`.
pub static COULOMB: Law = Law::of::<Coulomb, 2, 0>("BOW coulomb");
/// Law with `curve = "table"`.
pub static TABLE: Law = Law::of::<lnl::TableFriction, 2, 0>("BOW table")
    .loaded_by(|p, tick_dt, out| out.copy_from_slice(&[p[at::POINTS].unwrap_or(NONE), 1.0 / tick_dt]));

static OTHERS: &[&Law] = &[
    &SMOOTH_SECANT,
    &SMOOTH_NEWTON,
    &PIECEWISE,
    &PIECEWISE_SECANT,
    &PIECEWISE_NEWTON,
    &COULOMB,
    &COULOMB_SECANT,
    &COULOMB_NEWTON,
    &SET_VALUED,
    &TABLE,
    &TABLE_SECANT,
    &TABLE_NEWTON,
];

static LAWS: [[&Law; 4]; 4] = [
    [&SMOOTH, &SMOOTH_SECANT, &SMOOTH_NEWTON, &SMOOTH_NEWTON],
    [&PIECEWISE, &PIECEWISE_SECANT, &PIECEWISE_NEWTON, &PIECEWISE_NEWTON],
    [&COULOMB, &COULOMB_SECANT, &COULOMB_NEWTON, &SET_VALUED],
    [&TABLE, &TABLE_SECANT, &TABLE_NEWTON, &TABLE_NEWTON],
];

/// Law with `curve = "coulomb"` and `method = "set-valued"`; on masses with other implicit links a curve runs instead.
pub static SET_VALUED: Law = coulomb::alone("BOW set-valued", SLIDING, &SLIDING_TOGETHER);
static SLIDING: Law = Law::of::<SetValued, 3, 0>("BOW sliding");
static SLIDING_TOGETHER: Law = friction::together::<SetValued, _>("BOW set-valued shared", SLIDING);

/// Makes the laws of a curve by each method, alone and together with others.
macro_rules! methods {
    ($($curve:ident $phi:ty, $code:literal: $secant:ident $newton:ident $together:ident;)*) => {
        $(
            static $secant: Law = friction::alone::<$phi, _, false>(concat!($code, " secant"), $curve, &$together);
            static $newton: Law = friction::alone::<$phi, _, true>(concat!($code, " newton"), $curve, &$together);
            static $together: Law = friction::together::<$phi, _>(concat!($code, " shared"), $curve);
        )*

        pub(super) fn laws<R: Real>() -> impl IntoIterator<Item = LawEntry<R>> {
            let sliding = LawFns::of::<SetValued, 3, 0>();
            let of_curves = [
                $(
                    ($curve.code, LawFns::of::<$phi, _, 0>()),
                    ($secant.code, friction::alone_fns::<R, $phi, _, false>(LawFns::of::<$phi, _, 0>())),
                    ($newton.code, friction::alone_fns::<R, $phi, _, true>(LawFns::of::<$phi, _, 0>())),
                    ($together.code, friction::together_fns::<R, $phi, _>(LawFns::of::<$phi, _, 0>())),
                )*
            ];
            of_curves.into_iter().chain([
                (SET_VALUED.code, coulomb::fns(sliding)),
                (SLIDING_TOGETHER.code, friction::together_fns::<R, SetValued, _>(sliding)),
            ])
        }
    };
}

methods! {
    SMOOTH Smooth, "BOW smooth": SMOOTH_SECANT SMOOTH_NEWTON SMOOTH_TOGETHER;
    PIECEWISE Piecewise, "BOW piecewise": PIECEWISE_SECANT PIECEWISE_NEWTON PIECEWISE_TOGETHER;
    COULOMB Coulomb, "BOW coulomb": COULOMB_SECANT COULOMB_NEWTON COULOMB_TOGETHER;
    TABLE lnl::TableFriction, "BOW table": TABLE_SECANT TABLE_NEWTON TABLE_TOGETHER;
}

/// Returns a table of u exp(½ − u²/2) for u from 0 to 8. Beyond, the friction is below 1e-12 of its peak.
fn bell() -> Table {
    let n = 4096;
    let points: Vec<[f64; 2]> = (0..=n)
        .map(|i| {
            let u = 8.0 * f64::from(i) / f64::from(n);
            [u, u * libm::exp(0.5 - 0.5 * u * u)]
        })
        .collect();
    Table::new(&points).unwrap_or_else(|| unreachable!("4097 rising finite points"))
}

/// Coefficients f, 1/(v0 T), index of the bell table.
pub struct Smooth;

impl Phi<3, 0> for Smooth {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 3] {
        let bell = p.last().copied().flatten().unwrap_or(NONE);
        [p[at::F].unwrap_or(0.0), 1.0 / (p[at::V0].unwrap_or(1.0) * tick_dt), bell]
    }
    #[inline(always)]
    fn force<R: Real>(&[f, per, bell]: &[R; 3], _: &mut [R; 0], tables: &[Table<R>], _e: R, w: R) -> R {
        let u = w * per;
        tables.get(bell.wide() as usize).map_or(R::ZERO, |t| (f * t.at(u.abs())).copysign(u))
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 3], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        Self::force(c, &mut { *m }, t, e[1], w) * w
    }
    fn bound(c: &[f64; 3], tables: &[Table]) -> Bound {
        Bound { z: Self::steep(c, tables), curve: true, ..Bound::default() }
    }
}

impl Curve<3> for Smooth {
    fn steep<R: Real>(&[f, per, _]: &[f64; 3], _: &[Table<R>]) -> f64 {
        f * per * 1.648_721_270_700_128_2
    }
    fn chord<R: Real>(&[f, per, bell]: &[R; 3], tables: &[Table<R>], w: R) -> R {
        tables.get(bell.wide() as usize).map_or(R::ZERO, |t| f * per * t.chord((w * per).abs()))
    }
    fn slope<R: Real>(&[f, per, bell]: &[R; 3], tables: &[Table<R>], w: R) -> R {
        tables.get(bell.wide() as usize).map_or(R::ZERO, |t| f * per * t.slope((w * per).abs()))
    }
}

/// Coefficients f/(v0 T), v0 T, fd, slope of the fall, v1 T.
pub struct Piecewise;

impl Phi<5, 0> for Piecewise {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 5] {
        let (f, v0) = (p[at::F].unwrap_or(0.0), p[at::V0].unwrap_or(1.0) * tick_dt);
        let v1 = p[at::V1].map_or(3.0 * v0, |v| (v * tick_dt).max(v0 * (1.0 + 1e-9)));
        let fd = p[at::FD].unwrap_or(0.0).min(f);
        [f / v0, v0, fd, (f - fd) / (v1 - v0), v1]
    }
    #[inline(always)]
    fn force<R: Real>(&[rise, v0, fd, fall, v1]: &[R; 5], _: &mut [R; 0], _: &[Table<R>], _e: R, w: R) -> R {
        let v = w.abs();
        if v < v0 {
            rise * w
        } else if v < v1 {
            (fd + fall * (v1 - v)).copysign(w)
        } else {
            fd.copysign(w)
        }
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 5], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        Self::force(c, &mut { *m }, t, e[1], w) * w
    }
    fn bound(c: &[f64; 5], tables: &[Table]) -> Bound {
        Bound { z: Self::steep(c, tables), curve: true, ..Bound::default() }
    }
}

impl Curve<5> for Piecewise {
    fn steep<R: Real>(&[rise, _, _, fall, _]: &[f64; 5], _: &[Table<R>]) -> f64 {
        rise.max(fall)
    }
    fn chord<R: Real>(c: &[R; 5], tables: &[Table<R>], w: R) -> R {
        if w.abs() < c[1] { c[0] } else { Self::force(c, &mut [], tables, R::ZERO, w) / w }
    }
    fn slope<R: Real>(&[rise, v0, _, fall, v1]: &[R; 5], _: &[Table<R>], w: R) -> R {
        let v = w.abs();
        if v < v0 {
            rise
        } else if v < v1 {
            -fall
        } else {
            R::ZERO
        }
    }
}

/// Coefficients f, fd, and v0 T, the creep if it runs as a curve.
pub struct SetValued;

/// Default creep where links share a mass \[m/s\].
const CREEP: f64 = 1e-4;

impl Phi<3, 0> for SetValued {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 3] {
        let f = p[at::F].unwrap_or(0.0);
        [f, p[at::FD].unwrap_or(f).min(f), p[at::V0].unwrap_or(CREEP) * tick_dt]
    }
    #[inline(always)]
    fn force<R: Real>(c: &[R; 3], _: &mut [R; 0], _: &[Table<R>], _e: R, w: R) -> R {
        coulomb::sliding(*c, w)
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 3], _: &[R; 0], _: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        coulomb::sliding(*c, w) * w
    }
    fn bound(c: &[f64; 3], tables: &[Table]) -> Bound {
        Bound { z: Self::steep(c, tables), curve: true, ..Bound::default() }
    }
}

impl Curve<3> for SetValued {
    fn steep<R: Real>(&[f, _, v0]: &[f64; 3], _: &[Table<R>]) -> f64 {
        f / v0
    }
    fn chord<R: Real>(c: &[R; 3], _: &[Table<R>], w: R) -> R {
        coulomb::chord(*c, w)
    }
    fn slope<R: Real>(c: &[R; 3], _: &[Table<R>], w: R) -> R {
        if w.abs() <= c[2] { coulomb::chord(*c, w) } else { R::ZERO }
    }
}

/// Coefficients f/(v0 T), f.
pub struct Coulomb;

impl Phi<2, 0> for Coulomb {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 2] {
        let f = p[at::F].unwrap_or(0.0);
        [f / (p[at::V0].unwrap_or(1.0) * tick_dt), f]
    }
    #[inline(always)]
    fn force<R: Real>(&[rise, f]: &[R; 2], _: &mut [R; 0], _: &[Table<R>], _e: R, w: R) -> R {
        (rise * w).min(f).max(-f)
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 2], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        Self::force(c, &mut { *m }, t, e[1], w) * w
    }
    fn bound(c: &[f64; 2], tables: &[Table]) -> Bound {
        Bound { z: Self::steep(c, tables), curve: true, ..Bound::default() }
    }
}

impl Curve<2> for Coulomb {
    fn steep<R: Real>(&[rise, _]: &[f64; 2], _: &[Table<R>]) -> f64 {
        rise
    }
    fn chord<R: Real>(&[rise, f]: &[R; 2], _: &[Table<R>], w: R) -> R {
        (f / w.abs()).min(rise)
    }
    fn slope<R: Real>(&[rise, f]: &[R; 2], _: &[Table<R>], w: R) -> R {
        if rise * w.abs() < f { rise } else { R::ZERO }
    }
}
