//! STRING and CHAIN: masses in a row, linked by springs.
//!
//! Modes of N masses with the stiffness ratio a = kT²/m: fixed at both ends, f_j = (fs/π) asin(√a sin(jπ/(2(N+1))));
//! free, with sin(jπ/(2N)) (docs/numerics.md §1.2). For a given `f` the first is inverted exactly, damping included:
//! with damping to ground b every mode obeys λ_j = (1−r)² + 4r sin²(θ/2), r² = 1−b, as a CEL does. Source: CMJ 1993,
//! SMC 2019.

use ca_core::internal::mat::X;
use ca_core::{ABOVE_ZERO, Kind, Need, OneOf, POSITIVE, Param, Role, Type, Unit};

use crate::quantity::Plain;
use alloc::format;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::tuning::Scheme;

/// Largest number of masses of a generator.
pub(super) const MANY: u32 = crate::model::LARGEST as u32;
pub(super) const M: Param = Param::number("m", Unit::KILOGRAM, ABOVE_ZERO, Need::Optional, "inertia of each mass");
pub(super) const M_TOTAL: Param = Param::number(
    "m_total",
    Unit::KILOGRAM,
    ABOVE_ZERO,
    Need::Optional,
    "total inertia, divided equally among the masses",
);
pub(super) const K: Param = Param::number("k", Unit::STIFFNESS, POSITIVE, Need::Optional, "stiffness of each spring");
pub(super) const F: Param =
    Param::number("f", Unit::HERTZ, ABOVE_ZERO, Need::Optional, "fundamental frequency, exact at every sound rate");
pub(super) const Z: Param = Param::number(
    "z",
    Unit::VISCOSITY,
    POSITIVE,
    Need::Default(0.0),
    "viscosity of each link; damps high partials more",
);
pub(super) const ZO: Param = Param::number(
    "zo",
    Unit::VISCOSITY,
    POSITIVE,
    Need::Optional,
    "viscosity of each mass to ground; damps all partials equally",
);
pub(super) const T60: Param =
    Param::number("t60", Unit::SECOND, ABOVE_ZERO, Need::Optional, "time to decay by 60 dB, by damping to ground");
pub(super) const MASSES: OneOf = OneOf { sets: &[&["m"], &["m_total"]], required: true };
pub(super) const TUNING: OneOf = OneOf { sets: &[&["k"], &["f"]], required: true };
pub(super) const DECAY: OneOf = OneOf { sets: &[&["zo"], &["t60"]], required: false };

ca_core::choice! {
    /// Support of the ends.
    enum Ends {
        /// Fixed point at each end.
        Fixed = "fixed",
        Free = "free",
        /// Same as fixed: without bending stiffness there is nothing to clamp.
        Hinged = "hinged",
    }
}

/// STRING in the catalog.
pub static STRING: Kind = Kind {
    code: "STRING",
    title: "string",
    equation: "n MAS in a row, REF between neighbours; ends fixed, free or hinged",
    doc: "A string of `n` masses. Give it a pitch (`f`) and a decay (`t60`), or stiffness and viscosities. `low[0]` is \
          the first mass, `low[-1]` the last, `low@0.31` a point 31 % of the way between the ends. Hinged ends are the \
          same as fixed ends, since this string has no bending stiffness.",
    source: &["CMJ 1993", "SMC 2019"],
    params: &[
        Param::new("n", Type::Count { min: 1, max: MANY }, Need::Required, "number of masses"),
        M,
        M_TOTAL,
        K,
        F,
        Z,
        ZO,
        T60,
        Param::new("ends", Type::Choice(Ends::WORDS), Need::Default(0.0), "support of the ends"),
        X,
    ],
    one_of: &[MASSES, TUNING, DECAY],
    example: r#"
[STRING]
low = { n = 40, f = "110 Hz", t60 = "4 s", m = "1 g" }
[MAS]
hammer = { m = "10 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[8]"], k = "30 kN/m", z = "1 N s/m" }
[SOX]
out = { from = "low[3]", gain = 200 }
"#,
    role: Role::Generator(&Generator { dims: &[1], derive, build }),
};

/// CHAIN in the catalog.
pub static CHAIN: Kind = Kind {
    code: "CHAIN",
    title: "chain",
    equation: "n MAS in a row, REF between neighbours; free ends",
    doc: "A string with free ends, which links can join to other modules.",
    source: &["SMC 2019"],
    params: &[
        Param::new("n", Type::Count { min: 2, max: MANY }, Need::Required, "number of masses"),
        M,
        M_TOTAL,
        K,
        F,
        Z,
        ZO,
        T60,
        X,
    ],
    one_of: &[MASSES, TUNING, DECAY],
    example: r#"
[SOL]
wall = {}
[CHAIN]
tail = { n = 12, m = "1 g", k = "20 kN/m", z = "20 mN s/m" }
[RES]
tie = { between = ["wall", "tail[0]"], k = "20 kN/m" }
[MAS]
hammer = { m = "10 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "tail[-1]"], k = "30 kN/m", z = "1 N s/m" }
[SOX]
out = { from = "tail[5]", gain = 200 }
"#,
    role: Role::Generator(&Generator { dims: &[1], derive, build }),
};

pub(super) fn mass(a: &Args<'_>, n: usize) -> f64 {
    a.num("m").or_else(|| a.num("m_total").map(|m| m / n as f64)).unwrap_or(1.0)
}

/// Returns the viscosity to ground of a mass `m`: as written, or exactly from t60 (docs/numerics.md §1.5).
pub(super) fn ground(a: &Args<'_>, m: f64) -> f64 {
    match a.num("t60") {
        // for an implicit method the decay also depends on the fundamental, through the force after the tick
        Some(t60) => match (a.scheme, a.num("f")) {
            (Scheme::Implicit(_), Some(f)) => a.scheme.tuned(f, t60, a.tick_dt).map_or(0.0, |(_, b)| b) * m / a.tick_dt,
            (scheme, _) => scheme.damped(t60, a.tick_dt) * m / a.tick_dt,
        },
        None => a.or0("zo"),
    }
}

/// Returns the λ (like T²ω²) of a mode that sounds at `f` with viscosity to ground `zo`.
pub(super) fn target(a: &Args<'_>, f: f64, zo: f64, m: f64) -> Result<f64, Problem> {
    if f * a.tick_dt >= 0.5 {
        return Err(Problem {
            title: format!("{} Hz is not below half the sound rate", Plain(f)),
            param: "f",
            help: format!("stay below {} Hz, or raise `rate.sound`", Plain(0.5 / a.tick_dt)),
        });
    }
    a.scheme.stiffness(f, zo * a.tick_dt / m, a.tick_dt).ok_or_else(|| Problem {
        title: format!("no stiffness gives {} Hz with this `theta` at this sound rate", Plain(f)),
        param: "f",
        help: "use `theta = 0.25`, choose a lower pitch, or raise `rate.sound`".into(),
    })
}

/// Reports a spring that would exceed the stability limit. `by_t60` is true if it would not without `t60`.
pub(super) fn too_stiff(f: f64, n: usize, fewer: usize, by_t60: bool) -> Problem {
    let masses = if fewer == 1 { "at most 1 mass".into() } else { format!("at most {fewer} masses") };
    let f = Plain(f);
    if by_t60 {
        return Problem {
            title: format!("{n} masses cannot reach {f} Hz with so short a `t60` at this sound rate"),
            param: "t60",
            help: match fewer {
                0 => "use a longer `t60`, or raise `rate.sound`".into(),
                _ => format!("use a longer `t60`, or {masses}, or raise `rate.sound`"),
            },
        };
    }
    Problem {
        title: format!("{n} masses cannot reach {f} Hz at this sound rate"),
        param: "n",
        help: if fewer > 0 {
            format!("use {masses}, or raise `rate.sound`")
        } else {
            "choose a lower pitch, or raise `rate.sound`".into()
        },
    }
}

/// Returns true if `t60` is given and `fits` holds for the λ without viscosity to ground.
pub(super) fn fits_without_t60(a: &Args<'_>, f: f64, m: f64, fits: impl Fn(f64) -> bool) -> bool {
    a.num("t60").is_some() && target(a, f, 0.0, m).is_ok_and(fits)
}

/// Slots: m, k, z, zo.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    let n = a.count("n");
    let m = mass(a, n);
    let zo = ground(a, m);
    let free = a.code == "CHAIN" || Ends::of(a.num("ends")) == Ends::Free;
    let k = match a.num("f") {
        None => a.or0("k"),
        Some(f) => {
            let lambda = target(a, f, zo, m)?;
            let angle = |n: usize| core::f64::consts::FRAC_PI_2 / if free { n as f64 } else { n as f64 + 1.0 };
            let stiffness = |lambda: f64, n: usize| {
                let s = libm::sin(angle(n));
                lambda / (4.0 * s * s)
            };
            // the highest partial is at 4a sin², below the limit for a ≤ 1 and every n
            let fits = |lambda: f64, n: usize| stiffness(lambda, n) <= a.scheme.stability_limit();
            if !fits(lambda, n) {
                let fewer = (1..n).rev().find(|n| fits(lambda, *n)).unwrap_or(0);
                return Err(too_stiff(f, n, fewer, fits_without_t60(a, f, m, |lambda| fits(lambda, n))));
            }
            stiffness(lambda, n) * m / (a.tick_dt * a.tick_dt)
        }
    };
    slots.extend([Some(m), Some(k), a.num("z"), Some(zo)]);
    Ok(())
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let n = a.count("n");
    let free = a.code == "CHAIN" || Ends::of(a.num("ends")) == Ends::Free;
    let mut row = Vec::with_capacity(n + 2);
    if !free {
        row.push(b.anchor());
    }
    for i in 0..n {
        row.push(b.mass(i, 0, 3));
    }
    if !free {
        row.push(b.anchor());
    }
    for pair in row.windows(2) {
        b.link(pair[0], pair[1], 1, 2);
    }
    let len = row.len() as u32;
    b.set_path(row, [len, 1]);
    Ok(())
}
