//! LNL: a non-linear interaction given by a table.
//!
//! Equation: F = table(e), or F = table(de/dt), or their sum. The tables are points [[x, F], …], interpolated linearly
//! and held constant outside. Parameters: `spring` \[m, N\], `friction` \[m/s, N\]. Source: ICMC 2013 (LNL, look-up
//! tables). Stability: rule of thumb on the steepest segment within reach; a friction table is passive if F has the
//! sign of the speed. The law that runs reads only the tables that are given. Test: conformance suite, table tests.

use super::{
    ALONG, BETWEEN, Bound, ELASTIC_METHOD, L0, Law, LawEntry, LawFns, PAIRS, ParamBinding, Phi, SOFTEN, by_potential,
};
use crate::kind::{Kind, Need, Param, Role, Type, Unit};
use crate::method::friction::{self, Curve};
use crate::method::potential::{self, Numbers, Potential};
use crate::numeric::{NONE, Real, Table};
use crate::op::LoadFns;

/// LNL in the catalog.
pub static KIND: Kind = Kind {
    code: "LNL",
    title: "non-linear interaction by table",
    equation: "F = spring(e) + friction(de/dt)",
    doc: "A law given by points: `spring` gives the force over elongation, `friction` the force over relative speed. \
          Straight lines join the points, and the force is constant beyond the first and last point. F > 0 pulls the \
          ends together.",
    source: &["ICMC 2013"],
    params: &[
        BETWEEN,
        Param::new(
            "spring",
            Type::Points { x: Unit::METRE, y: Unit::NEWTON },
            Need::Optional,
            "points [elongation, force]",
        ),
        Param::new(
            "friction",
            Type::Points { x: Unit::SPEED, y: Unit::NEWTON },
            Need::Optional,
            "points [relative speed, force]",
        ),
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
[LNL]
spring = { between = ["wall", "bob"], spring = [["-2 mm", "-9 N"], ["-0.5 mm", "-1 N"], ["0.5 mm", "1 N"], ["2 mm", "9 N"]] }
[FRO]
air = { between = ["wall", "bob"], z = "3 mN s/m" }
[SOX]
out = { from = "bob", gain = 500 }
"#,
    role: Role::Lia(&LAW),
};

crate::kind::positions!(KIND: SPRING = "spring", FRICTION = "friction", METHOD = "method");

/// The law of LNL, replaced if there is only one table or another method.
pub static LAW: Law = Law::of::<Lnl, 3, 0>("LNL").or(OTHERS, |p| {
    let stable = by_potential(p, at::METHOD);
    match (p[at::SPRING], p[at::FRICTION]) {
        (_, ParamBinding::Absent) => Some(if stable { &SPRING_STABLE } else { &SPRING }),
        (ParamBinding::Absent, _) => Some(if stable { &FRICTION_STABLE } else { &FRICTION }),
        _ => stable.then_some(&STABLE),
    }
});
static OTHERS: &[&Law] = &[&SPRING, &FRICTION, &STABLE, &SPRING_STABLE, &FRICTION_STABLE];
/// Law with a spring table alone.
pub static SPRING: Law = Law::of::<TableSpring, 1, 0>("LNL spring");
/// Law with a friction table alone. BOW with `curve = "table"` runs the same.
pub static FRICTION: Law = Law::of::<TableFriction, 2, 0>("LNL friction");
static STABLE: Law = potential::alone::<Lnl, 3, 0>("LNL stable", RESISTING, Some(&SHARED));
static SHARED: Law = potential::shared::<Lnl, 3, 0>("LNL stable, shared", RESISTING);
/// Both tables, with the friction limited to its resisting part.
const RESISTING: Law = {
    let law = Law::of::<Lnl, 3, 0>("LNL");
    let bound: fn(&[f64], &[Table]) -> Bound = |c, tables| {
        let both: &[f64; 3] = c.first_chunk().unwrap_or(&[NONE; 3]);
        Bound { active: TableSpring::bound(&[both[0]], tables).active, ..Lnl::bound(both, tables) }
    };
    Law { at_load: LoadFns { bound, ..law.at_load }, ..law }
};
static SPRING_STABLE: Law =
    potential::alone::<TableSpring, 1, 0>("LNL spring stable", SPRING_LAW, Some(&SPRING_SHARED));
static SPRING_SHARED: Law = potential::shared::<TableSpring, 1, 0>("LNL spring stable, shared", SPRING_LAW);
const SPRING_LAW: Law = Law::of::<TableSpring, 1, 0>("LNL spring");
static FRICTION_STABLE: Law =
    friction::alone::<TableFriction, 2, false>("LNL friction stable", FRICTION_LAW, &FRICTION_SHARED);
static FRICTION_SHARED: Law = friction::together::<TableFriction, 2>("LNL friction stable, shared", FRICTION_LAW);
const FRICTION_LAW: Law = Law::of::<TableFriction, 2, 0>("LNL friction");

pub(super) fn laws<R: Real>() -> [LawEntry<R>; 9] {
    let (both, spring) = (LawFns::of::<Lnl, 3, 0>(), LawFns::of::<TableSpring, 1, 0>());
    let friction = LawFns::of::<TableFriction, 2, 0>();
    [
        (LAW.code, both),
        (SPRING.code, spring),
        (FRICTION.code, friction),
        (STABLE.code, potential::alone_fns::<R, Lnl, 3, 0>(both)),
        (SHARED.code, potential::shared_fns::<R, Lnl, 3, 0>(both)),
        (SPRING_STABLE.code, potential::alone_fns::<R, TableSpring, 1, 0>(spring)),
        (SPRING_SHARED.code, potential::shared_fns::<R, TableSpring, 1, 0>(spring)),
        (FRICTION_STABLE.code, friction::alone_fns::<R, TableFriction, 2, false>(friction)),
        (FRICTION_SHARED.code, friction::together_fns::<R, TableFriction, 2>(friction)),
    ]
}

/// F = table(e)
pub struct TableSpring;

impl Phi<1, 0> for TableSpring {
    fn coefs(p: &[Option<f64>], _te: f64) -> [f64; 1] {
        [p[at::SPRING].unwrap_or(NONE)]
    }
    #[inline(always)]
    fn force<R: Real>(&[n]: &[R; 1], _: &mut [R; 0], tables: &[Table<R>], e: R, _w: R) -> R {
        tables.get(n.wide() as usize).map_or(R::ZERO, |t| t.at(e))
    }
    #[inline(always)]
    fn potential<R: Real>(&[n]: &[R; 1], _: &[R; 0], tables: &[Table<R>], e: R) -> R {
        tables.get(n.wide() as usize).map_or(R::ZERO, |t| t.integral(e))
    }
    fn bound(&[n]: &[f64; 1], tables: &[Table]) -> Bound {
        let (hi, lo) = tables.get(n as usize).map_or((0.0, 0.0), Table::slopes);
        let k = hi.max(-lo);
        Bound { k, varying: k, active: lo < 0.0, ..Bound::default() }
    }
    fn steepest(&[n]: &[f64; 1], tables: &[Table], between: [f64; 2]) -> [f64; 2] {
        let (hi, lo) = tables.get(n as usize).map_or((0.0, 0.0), |t| t.slopes_between(between));
        [hi.max(-lo), 0.0]
    }
}

/// F = table(w/T); coefficients table, 1/T.
pub struct TableFriction;

impl Phi<2, 0> for TableFriction {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 2] {
        [p[at::FRICTION].unwrap_or(NONE), 1.0 / tick_dt]
    }
    #[inline(always)]
    fn force<R: Real>(&[n, fs]: &[R; 2], _: &mut [R; 0], tables: &[Table<R>], _e: R, w: R) -> R {
        tables.get(n.wide() as usize).map_or(R::ZERO, |t| t.at(w * fs))
    }
    #[inline(always)]
    fn lost<R: Real>(c: &[R; 2], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        let w = e[1] - e[0];
        Self::force(c, &mut { *m }, t, e[1], w) * w
    }
    fn bound(&[n, fs]: &[f64; 2], tables: &[Table]) -> Bound {
        let active = tables.get(n as usize).is_some_and(|t| !t.resists());
        Bound { z: Self::steep(&[n, fs], tables), curve: true, active, ..Bound::default() }
    }
}

impl Curve<2> for TableFriction {
    fn steep<R: Real>(&[n, fs]: &[f64; 2], tables: &[Table<R>]) -> f64 {
        let (hi, lo) = tables.get(n as usize).map_or((0.0, 0.0), Table::slopes);
        hi.max(-lo) * fs
    }
    fn chord<R: Real>(&[n, fs]: &[R; 2], tables: &[Table<R>], w: R) -> R {
        tables.get(n.wide() as usize).map_or(R::ZERO, |t| fs * t.chord(w * fs))
    }
    fn slope<R: Real>(&[n, fs]: &[R; 2], tables: &[Table<R>], w: R) -> R {
        tables.get(n.wide() as usize).map_or(R::ZERO, |t| fs * t.slope(w * fs))
    }
}

/// Both tables; coefficients spring table, friction table, 1/T.
pub struct Lnl;

impl Phi<3, 0> for Lnl {
    fn coefs(p: &[Option<f64>], tick_dt: f64) -> [f64; 3] {
        [p[at::SPRING].unwrap_or(NONE), p[at::FRICTION].unwrap_or(NONE), 1.0 / tick_dt]
    }
    #[inline(always)]
    fn force<R: Real>(&[a, b, fs]: &[R; 3], m: &mut [R; 0], tables: &[Table<R>], e: R, w: R) -> R {
        TableSpring::force(&[a], m, tables, e, w) + TableFriction::force(&[b, fs], m, tables, e, w)
    }
    #[inline(always)]
    fn potential<R: Real>(&[a, ..]: &[R; 3], m: &[R; 0], tables: &[Table<R>], e: R) -> R {
        TableSpring::potential(&[a], m, tables, e)
    }
    #[inline(always)]
    fn lost<R: Real>(&[_, b, fs]: &[R; 3], m: &[R; 0], t: &[Table<R>], e: [R; 3]) -> R {
        TableFriction::lost(&[b, fs], m, t, e)
    }
    fn bound(&[a, b, fs]: &[f64; 3], tables: &[Table]) -> Bound {
        let (s, f) = (TableSpring::bound(&[a], tables), TableFriction::bound(&[b, fs], tables));
        Bound { k: s.k, varying: s.varying, z: f.z, curve: true, active: s.active || f.active, ..Bound::default() }
    }
    fn steepest(&[a, b, fs]: &[f64; 3], tables: &[Table], between: [f64; 2]) -> [f64; 2] {
        let [k, _] = TableSpring::steepest(&[a], tables, between);
        [k, TableFriction::bound(&[b, fs], tables).z]
    }
}

impl Potential<1, 0> for TableSpring {
    fn energy<R: Real>(&[n, ..]: &Numbers<R>, tables: &[Table<R>], e: R) -> R {
        TableSpring::potential(&[n], &[], tables, e)
    }
    fn mean<R: Real>(&[n, ..]: &Numbers<R>, tables: &[Table<R>], a: R, s: R) -> [R; 2] {
        tables.get(n.wide() as usize).map_or([R::ZERO; 2], |t| t.mean(a, s))
    }
    fn viscosity<R: Real>(_: &[R; 1], _: &[R; 0], _: &[Table<R>], _: R, _: R) -> R {
        R::ZERO
    }
    fn most<R: Real>(&[n, ..]: &Numbers<R>, tables: &[Table<R>], _: R, _: R) -> R {
        tables.get(n.wide() as usize).map_or(R::ZERO, |t| R::of(t.most()))
    }
}

impl Potential<3, 0> for Lnl {
    fn energy<R: Real>(n: &Numbers<R>, tables: &[Table<R>], e: R) -> R {
        TableSpring::energy(n, tables, e)
    }
    fn mean<R: Real>(n: &Numbers<R>, tables: &[Table<R>], a: R, s: R) -> [R; 2] {
        TableSpring::mean(n, tables, a, s)
    }
    fn viscosity<R: Real>(&[_, friction, fs]: &[R; 3], _: &[R; 0], tables: &[Table<R>], _: R, w: R) -> R {
        TableFriction::chord(&[friction, fs], tables, w).max(R::ZERO)
    }
    fn most<R: Real>(n: &Numbers<R>, tables: &[Table<R>], a: R, to: R) -> R {
        TableSpring::most(n, tables, a, to)
    }
}
