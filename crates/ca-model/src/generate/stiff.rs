//! STIFFSTRING: a string with bending stiffness, as piano strings and bars.
//!
//! Bending, −B δ⁴, is expressed by ordinary links: the energy ½B(x_{i−1} − 2x_i + x_{i+1})² of each inner node is two
//! springs of 2B to its neighbours and one of −B across it. Positive springs to second neighbours, which others use,
//! flatten the partials instead of sharpening them. The sum is never negative, which the certificate proves by covering
//! each −B with the springs beside it.
//!
//! Hinged modes: λ_j = 4k s_j² + 16B s_j⁴, s_j = sin(jπ/(2(N+1))). For given `f` and `b`, partials 1 and 2 are exactly
//! at f_j = j f √((1 + b j²)/(1 + b)); B also compensates for dispersion (docs/numerics.md §1.2). Source: Bilbao 2009.

use super::string::{DECAY, F, K, M, M_TOTAL, MANY, MASSES, T60, TUNING, Z, ZO, ground, mass, target, too_stiff};
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::{Kind, Need, OneOf, POSITIVE, Param, Role, Type, Unit};

ca_core::choice! {
    /// Support of the ends.
    enum Ends {
        /// Fixed point about which the string can turn.
        Hinged = "hinged",
        /// Fixed point in which it is clamped.
        Fixed = "fixed",
        Free = "free",
    }
}

/// STIFFSTRING in the catalog.
pub static KIND: Kind = Kind {
    code: "STIFFSTRING",
    title: "stiff string",
    equation: "STRING plus bending: f_j ≈ j f sqrt((1 + b j²)/(1 + b))",
    doc: "A string with bending stiffness: its partials are stretched, as in a piano (`b` about 1e-4) or a bar (`k = 0` \
          with `kb`). With `f`, the ends must be hinged; then the first two partials are exact and higher ones are \
          flat: for `n = 40` and `b = 4e-4`, 0.7 cents at partial 6 and 6 cents at partial 10 (docs/numerics.md §1.2).",
    source: &["Bilbao 2009", "SMC 2019"],
    params: &[
        Param::new("n", Type::Count { min: 3, max: MANY }, Need::Required, "number of masses"),
        M,
        M_TOTAL,
        K,
        F,
        Param::number("kb", Unit::STIFFNESS, POSITIVE, Need::Optional, "bending stiffness EI/h³ of each node"),
        Param::number(
            "b",
            Unit::NONE,
            POSITIVE,
            Need::Optional,
            "inharmonicity, with `f`: partial j is at j f sqrt((1 + b j²)/(1 + b))",
        ),
        Z,
        ZO,
        T60,
        Param::new(
            "ends",
            Type::Choice(Ends::WORDS),
            Need::Default(0.0),
            "hinged: fixed point, free to turn; fixed: clamped; free: no support",
        ),
        X,
    ],
    one_of: &[MASSES, TUNING, OneOf { sets: &[&["k", "kb"], &["f", "b"]], required: false }, DECAY],
    example: r#"
[STIFFSTRING]
low = { n = 30, f = "110 Hz", b = 1e-3, t60 = "3 s", m = "1 g" }
[MAS]
hammer = { m = "10 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[6]"], k = "30 kN/m", z = "1 N s/m" }
[SOX]
out = { from = "low[3]", gain = 200 }
"#,
    role: Role::Generator(&Generator { dims: &[1], derive, build }),
};

/// Slots: m, z, zo, −B across a node, then the springs between neighbours with 0, 1, 2, 3 and 4 shares of B.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    let n = a.count("n");
    let m = mass(a, n);
    let zo = ground(a, m);
    let (k, bend) = match a.num("f") {
        None => (a.or0("k"), a.or0("kb")),
        Some(f) => {
            if Ends::of(a.num("ends")) != Ends::Hinged {
                return Err(Problem {
                    title: "`f` of a stiff string needs hinged ends".into(),
                    param: "ends",
                    help: "use `ends = \"hinged\"`, or give `k` and `kb`".into(),
                });
            }
            let first = target(a, f, zo, m)?;
            let b = a.or0("b");
            // partial 2 is silent above half the rate, and then cannot determine the bending
            let second = target(a, 2.0 * f * libm::sqrt((1.0 + 4.0 * b) / (1.0 + b)), zo, m).ok();
            let solve = |n: usize| bending(n, first, second, b);
            let fits = |n: usize| {
                let (k, bend) = solve(n);
                k + 4.0 * bend <= a.scheme.stability_limit()
            };
            if !fits(n) {
                return Err(too_stiff(f, n, (3..n).rev().find(|n| fits(*n)).unwrap_or(0), false));
            }
            let (k, bend) = solve(n);
            let unit = m / (a.tick_dt * a.tick_dt);
            (k * unit, bend * unit)
        }
    };
    slots.extend([Some(m), a.num("z"), Some(zo), Some(-bend)]);
    slots.extend((0..=4).map(|shares| Some(k + f64::from(shares) * bend)));
    Ok(())
}

/// Returns the springs k and the bending B of `n` masses whose first two partials have these λ: 4k s_j² + 16B s_j⁴ =
/// λ_j for j = 1 and 2. Both are at least 0: pure bending, or a plain string, meets the first partial only.
fn bending(n: usize, first: f64, second: Option<f64>, b: f64) -> (f64, f64) {
    let n1 = n as f64 + 1.0;
    let square = |j: f64| {
        let s = libm::sin(j * core::f64::consts::FRAC_PI_2 / n1);
        s * s
    };
    let (s1, s2) = (square(1.0), square(2.0));
    let r1 = first / (4.0 * s1);
    let bend = if let Some(second) = second {
        (second / (4.0 * s2) - r1) / (4.0 * (s2 - s1))
    } else {
        let beta = b * n1 * n1 / (core::f64::consts::PI * core::f64::consts::PI);
        beta * r1 / (1.0 + 4.0 * beta * s1)
    };
    let bend = bend.clamp(0.0, r1 / (4.0 * s1));
    (r1 - 4.0 * bend * s1, bend)
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let n = a.count("n");
    let ends = Ends::of(a.num("ends"));
    let mut row = Vec::with_capacity(n + 2);
    if ends != Ends::Free {
        row.push(b.anchor());
    }
    for i in 0..n {
        row.push(b.mass(i, 0, 2));
    }
    if ends != Ends::Free {
        row.push(b.anchor());
    }
    let last = row.len() - 2;
    for (i, pair) in row.windows(2).enumerate() {
        // each inner node beside the link adds 2 shares; a clamp, whose outer neighbour is at rest too, adds 2 − 1
        let inner = u32::from(i > 0) * 2 + u32::from(i < last) * 2;
        let clamp = u32::from(ends == Ends::Fixed) * (u32::from(i == 0) + u32::from(i == last));
        b.link(pair[0], pair[1], 4 + inner + clamp, 1);
    }
    if !b.nothing(3) {
        for three in row.windows(3) {
            b.link(three[0], three[2], 3, NONE);
        }
    }
    let len = row.len() as u32;
    b.set_path(row, [len, 1]);
    Ok(())
}

/// Marks a missing slot: the parameter is absent.
const NONE: u32 = u32::MAX;
