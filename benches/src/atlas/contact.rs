//! Contacts: a ball that hits a wall once, at any phase of a tick.
//!
//! The measure is the energy over one bounce, not the growth over many. The explicit contact does not diverge by a
//! linear instability: it makes or loses energy, and the amount depends on the phase (docs/numerics.md §3.2). Without
//! damping, the bounce has a closed form. With damping, there is a rule on one side and a proof on the other, and no
//! statement between them.

use super::{Axis, Line, Map};
use crate::{mat, scene};
use ca_core::{Scene, State, tick};

/// Compiles a ball of 1 kg and its contact with a wall, at one tick a second: a is k and b is z.
pub fn contact(a: f64, b: f64, method: &str) -> Scene {
    let text = format!(
        "[rate]\nsound = 1\ngesture = 1\n[SOL]\nwall = {{}}\n[MAS]\nball = {{ m = 1 }}\n[BUT]\n\
         hit = {{ between = [\"wall\", \"ball\"], k = {a:?}, z = {b:?}, method = \"{method}\" }}\n[SOX]\n\
         out = {{ from = \"ball\" }}\n"
    );
    scene(&text)
}

/// Returns energy after over energy before one bounce that starts at x₋₁ = φ + 1, x₀ = φ, until the ball has left or
/// come to rest.
pub fn ratio(scene: &Scene, start: &State, phase: f64) -> f64 {
    let ball = mat(scene, "ball");
    let mut s = start.clone();
    (s.x[ball], s.d[ball]) = (phase, -1.0);
    for _ in 0..20_000 {
        tick(scene, &mut s);
        let (x, d) = (s.x[ball], s.d[ball]);
        if x > 0.0 && d > 0.0 || x.abs() < 1e-6 && d.abs() < 1e-6 {
            break;
        }
    }
    s.d[ball] * s.d[ball]
}

/// Returns the ratio for the undamped explicit contact in closed form.
///
/// In contact the ball is an oscillator with 2 sin(θ/2) = √a, so x_j = −((1 − φ) sin jθ + φ sin (j − 1)θ)/sin θ, until
/// this is no longer below the wall.
pub fn exact(a: f64, phase: f64) -> f64 {
    let theta = (1.0 - 0.5 * a).acos();
    let x = |j: f64| -((1.0 - phase) * (j * theta).sin() + phase * ((j - 1.0) * theta).sin()) / theta.sin();
    let mut j = 2.0;
    while x(j) < 0.0 {
        j += 1.0;
    }
    (x(j) - x(j - 1.0)).powi(2)
}

/// Returns the largest energy after over energy before, over `phases` of a tick.
fn most(a: f64, b: f64, method: &str, phases: u32) -> f64 {
    let scene = contact(a, b, method);
    let start = scene.state();
    let phase = |p: u32| (f64::from(p) + 0.5) / f64::from(phases);
    (0..phases)
        .map(|p| ratio(&scene, &start, phase(p)))
        .fold(0.0, |m, r| if r.is_nan() { f64::INFINITY } else { r.max(m) })
}

const WORDS: [&str; 2] = ["energy kept or taken", "energy made"];

/// Returns the stiffness at which a contact lasts exactly `n` ticks at any phase.
fn neutral(n: u32) -> f64 {
    2.0 - 2.0 * (std::f64::consts::PI / f64::from(n)).cos()
}

/// Energy of one undamped bounce, over stiffness and phase.
pub const PHASE: Map = Map {
    name: "bounce",
    title: "An explicit contact without damping: one bounce, by phase",
    text: "A ball hits a wall by a BUT of `method = \"ca\"`; at the last free tick its distance is a part φ of its \
           motion in a tick. The energy after the bounce, over the energy before, is 1 + a (|x_q x_(q+1)| − |x_(p−1) \
           x_p|)/(vT)², which lies in [1 − a/4, 1/(1 − a/4)]. The thin lines are the stiffnesses a = 2 − 2 cos(π/N), \
           which make no energy at any phase, and the curve is φ = 1 − 2/a, below which a contact of one tick makes \
           energy.",
    axes: [Axis::of("a = k T²/m", 0.0, 4.0), Axis::of("phase φ [ticks]", 0.0, 1.0)],
    words: WORDS,
    measured: |a, phase| {
        let scene = contact(a, 0.0, "ca");
        ratio(&scene, &scene.state(), phase) > 1.0 + 1e-9
    },
    theory: |a, phase| (a > 0.0 && a < 4.0).then(|| exact(a, phase) > 1.0 + 1e-9),
    lines: || {
        let mut lines: Vec<Line> = (2..=10).map(|n| Line::rule([neutral(n), 0.0], [neutral(n), 1.0])).collect();
        lines.push(Line::curve(2.0, 4.0, |a| [a, 1.0 - 2.0 / a]));
        lines
    },
    band: 0.004,
};

/// Bounce at any phase, over stiffness and viscosity.
pub const VISCOUS: Map = Map {
    name: "contact",
    title: "An explicit contact with damping, at any phase",
    text: "The same ball at forty phases of a tick; a cell makes energy if one of them does. Within the wedge a ≤ \
           1, 0.12 a ≤ b ≤ 1.9 − a none may (the rule of `ca check`). Beyond a + b = 2 a contact of one tick does, by \
           x' − x = a s + b − 1 at a depth s up to 1. Between the two there is no prediction: use `stable` there.",
    axes: [Axis::of("a = k T²/m", 0.0, 3.0), Axis::of("b = z T/m", 0.0, 2.5)],
    words: WORDS,
    measured: |a, b| most(a, b, "ca", 40) > 1.0 + 1e-12,
    theory: |a, b| {
        if a <= 1.0 && 0.12 * a <= b && b <= 1.9 - a {
            return Some(false);
        }
        (a + b > 2.0).then_some(true)
    },
    lines: || {
        vec![
            Line::edge(vec![[0.0, 0.0], [1.0, 0.12], [1.0, 0.9], [0.0, 1.9], [0.0, 0.0]]),
            Line::edge(vec![[2.0, 0.0], [0.0, 2.0]]),
        ]
    },
    band: 0.01,
};

/// Returns the allowance for rounding: the position of the ball is of the order of one tick's motion, its depth 1/√a
/// times that.
fn rounding(a: f64) -> f64 {
    1e-12 + 8.0 * f64::EPSILON * a.sqrt()
}

/// Contacts that keep energy, with the force in closed form.
pub const STABLE: Map = Map {
    name: "stable",
    title: "A contact of `method = \"stable\"`",
    text: "The ball and the wall again, at eight phases, with the force in closed form. No stiffness and no viscosity \
           makes energy, up to 10¹⁶ times the mass over a tick squared; the rounding of the depth may change 8 ε √a \
           of the energy.",
    axes: [Axis::log("a = k T²/m", -2.0, 16.0), Axis::log("b = z T/m", -3.0, 9.0)],
    words: WORDS,
    measured: |a, b| most(a, b, "stable", 8) > 1.0 + rounding(a),
    theory: |_, _| Some(false),
    lines: Vec::new,
    band: 0.0,
};

/// Contacts that keep energy, solved together.
pub const STABLE3D: Map = Map {
    name: "stable3d",
    title: "A contact of `method = \"stable3d\"`",
    text: "The same by the method for contacts in space or that share a mass.",
    measured: |a, b| most(a, b, "stable3d", 8) > 1.0 + rounding(a),
    ..STABLE
};
