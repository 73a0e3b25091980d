//! Linear networks, explicit: one oscillator, a chain, a mesh, two masses, and a tetrahedron coupled to cells.
//!
//! Theory is the eigenvalue bound of docs/numerics.md §1.3, S = M − T²K/4 − TC/2 > 0. All these networks have dampers
//! parallel to their springs, with the same ratio, so that C is K times z/k. The bound then is a straight line, (a +
//! 2b) λ < 4, and the largest eigenvalue λ of the network is known in closed form.

use super::{Axis, Line, Map, growth};
use crate::scene;
use ca_core::tick;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Ticks per run. Growth of 0.14 % a tick doubles the motion in the last quarter; half a percent beyond any boundary
/// here, growth is faster.
const TICKS: usize = 2000;

/// Returns true if a network grows after each mass was displaced by a random part of `size` \[m\].
pub(super) fn grows(text: &str, size: f64) -> bool {
    let scene = scene(text);
    let mut s = scene.state();
    let mut seed = 88_172_645_463_325_252u64;
    for i in 0..scene.counts.n_mat {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        // fixed points have mobility 0 and stay
        if s.coef[2 * scene.counts.n_mat + i] > 0.0 {
            s.x[i] = size * (0.5 + 0.5 * (seed >> 11) as f64 / (1u64 << 53) as f64) * f64::from(1 - 2 * (i % 2) as i8);
        }
    }
    let step = || {
        tick(&scene, &mut s);
        // the change per tick does not depend on the position of a free network
        s.d.iter().fold(0.0, |m: f64, d| if d.is_nan() { f64::NAN } else { m.max(d.abs() / size) })
    };
    growth(TICKS, step) > 2.0
}

/// One tick a second, so that a is k and b is z for masses of 1 kg.
pub(super) const RATE: &str = "[rate]\nsound = 1\ngesture = 1\n";

/// Returns the line (a + 2b) λ = 4, the stability boundary of a network with largest eigenvalue λ.
pub(super) fn edge(lambda: f64) -> Vec<Line> {
    vec![Line::edge(vec![[4.0 / lambda, 0.0], [0.0, 2.0 / lambda]])]
}

pub(super) fn beyond(lambda: f64, a: f64, b: f64) -> bool {
    (a + 2.0 * b) * lambda >= 4.0
}

pub(super) const WORDS: [&str; 2] = ["stays bounded", "grows"];

/// A mass on a spring and a damper.
pub const OSCILLATOR: Map = Map {
    name: "oscillator",
    title: "One mass on a spring and a damper",
    text: "A MAS of mass m tied to a SOL by a REF. It is stable if and only if a + 2b < 4 (k T² + 2 z T < 4 m).",
    axes: [Axis::of("a = k T²/m", 0.0, 5.0), Axis::of("b = z T/m", 0.0, 2.5)],
    words: WORDS,
    measured: |a, b| {
        let link = format!("tie = {{ between = [\"wall\", \"bob\"], k = {a:?}, z = {b:?} }}");
        grows(
            &format!(
                "{RATE}[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = 1 }}\n[REF]\n{link}\n[SOX]\nout = {{ from = \"bob\" }}\n"
            ),
            1.0,
        )
    },
    theory: |a, b| Some(beyond(1.0, a, b)),
    lines: || edge(1.0),
    band: 0.005,
};

const N: usize = 16;

/// Returns 2 − 2 cos of the highest mode of N masses between fixed ends.
fn chain() -> f64 {
    2.0 - 2.0 * (N as f64 * PI / (N as f64 + 1.0)).cos()
}

/// A string between fixed ends.
pub const CHAIN: Map = Map {
    name: "chain",
    title: "A string of 16 masses",
    text: "A STRING between fixed ends, with k and z in each of its links. Its highest mode has λ = 4 sin²(16 π/34), \
           and it is stable if and only if (a + 2b) λ < 4.",
    axes: [Axis::of("a = k T²/m", 0.0, 1.4), Axis::of("b = z T/m", 0.0, 0.7)],
    words: WORDS,
    measured: |a, b| {
        grows(
            &format!(
                "{RATE}[STRING]\ns = {{ n = {N}, m = 1, k = {a:?}, z = {b:?} }}\n[SOX]\nout = {{ from = \"s[0]\" }}\n"
            ),
            1.0,
        )
    },
    theory: |a, b| Some(beyond(chain(), a, b)),
    lines: || edge(chain()),
    band: 0.005,
};

const SIDE: usize = 6;

/// Returns the eigenvalue of the highest mode of a free mesh: twice the one of a free chain along a side.
fn mesh() -> f64 {
    let side = SIDE as f64;
    2.0 * (2.0 - 2.0 * ((side - 1.0) * PI / side).cos())
}

/// A free square mesh.
pub const MESH: Map = Map {
    name: "mesh",
    title: "A free mesh of 6 × 6 masses",
    text: "A free MESH. Its highest mode has λ = 4 − 4 cos(5 π/6), and it is stable if and only if (a + \
           2b) λ < 4. A motion of the whole mesh does not count as growth.",
    axes: [Axis::of("a = k T²/m", 0.0, 0.8), Axis::of("b = z T/m", 0.0, 0.4)],
    words: WORDS,
    measured: |a, b| {
        let mesh = format!("skin = {{ nx = {SIDE}, ny = {SIDE}, m = 1, k = {a:?}, z = {b:?} }}");
        grows(&format!("{RATE}[MESH]\n{mesh}\n[SOX]\nout = {{ from = \"skin[0,0]\" }}\n"), 1.0)
    },
    theory: |a, b| Some(beyond(mesh(), a, b)),
    lines: || edge(mesh()),
    band: 0.005,
};

/// Returns true if two masses of this ratio grow on one spring and damper.
fn pair_grows(ratio: f64, a: f64, b: f64) -> bool {
    let masses = format!("light = {{ m = 1 }}\nheavy = {{ m = {ratio:?} }}");
    let link = format!("tie = {{ between = [\"light\", \"heavy\"], k = {a:?}, z = {b:?} }}");
    grows(&format!("{RATE}[MAS]\n{masses}\n[REF]\n{link}\n[SOX]\nout = {{ from = \"light\" }}\n"), 1.0)
}

/// Two masses and a spring.
pub const PAIR: Map = Map {
    name: "pair",
    title: "A light mass on a heavy one",
    text: "Two MAS, m and M, tied by a REF, with nothing else. The mobility 1/m + 1/M decides: stable if and only if \
           a (1 + m/M) < 4, for any ratio.",
    axes: [Axis::log("M/m", 0.0, 6.0), Axis::of("a = k T²/m", 0.0, 5.0)],
    words: WORDS,
    measured: |ratio, a| pair_grows(ratio, a, 0.0),
    theory: |ratio, a| Some(beyond(1.0 + 1.0 / ratio, a, 0.0)),
    lines: || vec![Line::curve(0.0, 6.0, |e| [10f64.powf(e), 4.0 / (1.0 + 10f64.powf(-e))])],
    band: 0.005,
};

/// The same pair, damped.
pub const PAIR_DAMPED: Map = Map {
    name: "pair_damped",
    title: "A light mass on a heavy one, damped",
    text: "The same with a spring of a = 0.5 and a damper beside it: stable if and only if (0.5 + 2b) (1 + m/M) < 4.",
    axes: [Axis::log("M/m", 0.0, 6.0), Axis::of("b = z T/m", 0.0, 2.5)],
    measured: |ratio, b| pair_grows(ratio, 0.5, b),
    theory: |ratio, b| Some(beyond(1.0 + 1.0 / ratio, 0.5, b)),
    lines: || vec![Line::curve(0.0, 6.0, |e| [10f64.powf(e), 2.0 / (1.0 + 10f64.powf(-e)) - 0.25])],
    ..PAIR
};

/// Stiffness of the cells below.
const CELL: f64 = 1.0;

/// a + 2b of an LPR at the boundary.
///
/// The breathing mode of the tetrahedron has 4 k/m. With cells of k T²/m = c, the two by two matrix [4a, 2a; 2a, a + c]
/// must stay below 4: (4 − 4a)(4 − a − c) = 4a².
const TETRA: f64 = (4.0 - CELL) / (5.0 - CELL);

/// A tetrahedron whose edges are coupled to cells.
pub const LPR: Map = Map {
    name: "lpr",
    title: "A tetrahedron in space that sounds on a line, by six LPR",
    text: "Four MAS in space, a cell on a line for each of the six edges, all of mass m and the cells of k T²/m = 1; \
           each edge is an LPR onto its cell. Linearised, the breathing mode and its cells decide: stable if and only \
           if a + 2b < (4 − 1)/(5 − 1) = 0.75 (the stretching modes of a tetrahedron are 4, 2 and 1 times k/m). \
           Played from displacements of 1e-8 of an edge.",
    axes: [Axis::of("a = k T²/m", 0.0, 1.0), Axis::of("b = z T/m", 0.0, 0.5)],
    words: WORDS,
    measured: |a, b| {
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let (mut t, half) = (format!("{RATE}[room]\ndim = 3\n[room.MAS]\n"), 0.125f64.sqrt());
        for (i, corner) in corners.iter().enumerate() {
            let _ = writeln!(t, "p{i} = {{ m = 1, x = {:?} }}", corner.map(|c: f64| c * half));
        }
        let _ = writeln!(t, "[SOL]\nwall = {{}}\n[CEL]");
        for i in 0..6 {
            let _ = writeln!(t, "c{i} = {{ m = 1, k = {CELL:?} }}");
        }
        let list = |name: &str, n: usize| (0..n).map(|i| format!("\"{name}{i}\"")).collect::<Vec<_>>().join(", ");
        let (p, c) = (list("room.p", 4), list("c", 6));
        let _ = writeln!(
            t,
            "[LPR]\nedges = {{ between = [[{p}], [{p}]], onto = [\"wall\", [{c}]], k = {a:?}, z = {b:?} }}\n[SOX]\n\
             out = {{ from = \"c0\" }}"
        );
        grows(&t, 1e-8)
    },
    theory: |a, b| Some(beyond(4.0 / TETRA, a, b)),
    lines: || edge(4.0 / TETRA),
    band: 0.005,
};
