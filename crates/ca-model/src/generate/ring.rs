//! RING: masses in a circle, each linked to the next by a spring and the last to the first.
//!
//! Modes of n masses with the stiffness ratio a = kT²/m are λ_j = 4a sin²(jπ/n), j = 0 … ⌊n/2⌋. At j = 0 the whole ring
//! moves, without a pitch. Each other j except n/2 is two modes of one pitch, as cos and sin around the ring
//! (docs/numerics.md §1.2). For given `f`, j = 1 is inverted exactly, with damping, as for STRING. Source: SMC 2019.
//!
//! The limit follows from the highest mode of the ring. A row never reaches 4a, but a ring of an even number of masses
//! does, so the rule a ≤ 1 of STRING would accept a ring that is at the limit and grows. The explicit method adds twice
//! the viscosity to ground. The first mass is at both ends of the path of a moving point, so no other code needs to
//! know circles, but a point moves from 0 to 1 and cannot go round repeatedly.

use super::string::{
    DECAY, F, K, M, M_TOTAL, MANY, MASSES, T60, TUNING, Z, ZO, fits_without_t60, ground, mass, target, too_stiff,
};
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::internal::tuning::Scheme;
use ca_core::{Kind, Need, Param, Role, Type};

/// RING in the catalog.
pub static KIND: Kind = Kind {
    code: "RING",
    title: "ring",
    equation: "n MAS in a circle, REF between neighbours; no support",
    doc: "A closed chain of `n` masses, such as a hoop or the rim of a bell. It has no support: a push on one side \
          moves the whole ring, unless links hold it. `hoop[0]` is the first mass, joined to `hoop[1]` and `hoop[-1]`. \
          `hoop@0.31` is a point 31 % of the way around from the first mass; both `hoop@0` and `hoop@1` are the first \
          mass.",
    source: &["SMC 2019"],
    params: &[
        Param::new("n", Type::Count { min: 3, max: MANY }, Need::Required, "number of masses"),
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
[RING]
hoop = { n = 24, f = "330 Hz", t60 = "2 s", m = "1 g" }
[RES]
tie = { between = ["wall", "hoop[12]"], k = "20 kN/m" }
[MAS]
hammer = { m = "10 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "hoop[0]"], k = "30 kN/m", z = "1 N s/m" }
[SOX]
out = { from = "hoop[5]", gain = 200 }
"#,
    role: Role::Generator(&Generator { dims: &[1], derive, build }),
};

fn sin2(j: usize, n: usize) -> f64 {
    let s = libm::sin(core::f64::consts::PI * j as f64 / n as f64);
    s * s
}

/// Slots: m, k, z, zo.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    let n = a.count("n");
    let m = mass(a, n);
    let zo = ground(a, m);
    let k = match a.num("f") {
        None => a.or0("k"),
        Some(f) => {
            let lambda = target(a, f, zo, m)?;
            let drag = if a.scheme == Scheme::Explicit { 2.0 * zo * a.tick_dt / m } else { 0.0 };
            // below the limit by more than rounding: a ring at the limit grows
            let limit = 4.0 * a.scheme.stability_limit() * (1.0 - 1e-9);
            let fits = |lambda: f64, drag: f64, n: usize| lambda * sin2(n / 2, n) / sin2(1, n) + drag < limit;
            if !fits(lambda, drag, n) {
                let fewer = (3..n).rev().find(|n| fits(lambda, drag, *n)).unwrap_or(0);
                return Err(too_stiff(f, n, fewer, fits_without_t60(a, f, m, |lambda| fits(lambda, 0.0, n))));
            }
            lambda / (4.0 * sin2(1, n)) * m / (a.tick_dt * a.tick_dt)
        }
    };
    slots.extend([Some(m), Some(k), a.num("z"), Some(zo)]);
    Ok(())
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let n = a.count("n");
    let mut circle = Vec::with_capacity(n + 1);
    for i in 0..n {
        circle.push(b.mass(i, 0, 3));
    }
    circle.extend(circle.first().copied());
    for pair in circle.windows(2) {
        b.link(pair[0], pair[1], 1, 2);
    }
    let len = circle.len() as u32;
    b.set_path(circle, [len, 1]);
    Ok(())
}
