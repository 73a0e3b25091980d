//! Friction of a bow, explicit.
//!
//! The map asks a question whose answer has a closed form: whether a gripped bar stays gripped. At small relative speed
//! the friction curve is a viscosity, its slope, so the bound of the oscillator applies. Beyond it the bar does not
//! grow by a factor, since friction has a largest force: it chatters.

use super::{Axis, Line, Map, growth};
use crate::{mat, scene};
use ca_core::tick;

/// e^½, the slope of the smooth curve at rest over f/v0.
const SLOPE: f64 = 1.648_721_270_700_128_2;

/// Initial distance of the bar from the grip \[v0 T\]; the curve is straight up to a million times this.
const BEGIN: f64 = 1e-9;

/// Returns the text of a bar of 1 kg under a bow at rest; v0 is 1 m/s and a tick is a second.
pub(super) fn gripped(a: f64, b: f64) -> String {
    format!(
        "[rate]\nsound = 1\ngesture = 1\n[SOL]\nbow = {{}}\n[CEL]\nbob = {{ m = 1, k = {a:?} }}\n[BOW]\n\
         rub = {{ between = [\"bow\", \"bob\"], f = {:?}, v0 = 1 }}\n[SOX]\nout = {{ from = \"bob\" }}\n",
        b / SLOPE
    )
}

/// Grip of a bow, over the stiffness of the bar and the slope of the friction.
pub const BOW: Map = Map {
    name: "bow",
    title: "A bar gripped by a bow, explicit",
    text: "A CEL of mass m, and a BOW of the smooth curve on a fixed point, from a displacement of 1e-9 of v0 T. With b = √e \
           f T/(v0 m), the steepest slope of the friction, the bar sticks if and only if a + 2b < 4. Beyond this \
           limit it oscillates: the force in a tick is at most the largest force, but explicit friction makes energy \
           there, and the amplitude rises with the slope (see the extremes below). Below b = 1 its speed decays \
           without changing sign; sticking is accurate up to b = 0.5 and fails at 1.5: these two thin lines concern \
           accuracy, and cells are not judged by them.",
    axes: [Axis::of("a = k T²/m", 0.0, 5.0), Axis::of("b = √e f T/(v0 m)", 0.0, 2.5)],
    words: ["grip holds", "chatters"],
    measured: |a, b| {
        let scene = scene(&gripped(a, b));
        let mut s = scene.state();
        let bar = mat(&scene, "bob");
        s.x[bar] = BEGIN;
        let step = || {
            tick(&scene, &mut s);
            s.d.iter().fold(0.0, |m: f64, d| m.max(d.abs() / BEGIN))
        };
        growth(2000, step) > 2.0
    },
    theory: |a, b| Some(a + 2.0 * b >= 4.0),
    lines: || {
        let rules = [0.5, 1.5].map(|b| Line::rule([0.0, b], [5.0, b]));
        [&[Line::edge(vec![[4.0, 0.0], [0.0, 2.0]])], &rules[..]].concat()
    },
    band: 0.005,
};
