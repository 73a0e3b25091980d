//! Shared models: one mass on a spring, a string; and the frequency of a mode.

use crate::play::{PI, apart};
use ca_core::{Scene, State, tick};

pub const FS: f64 = 48000.0;

/// One mass on a spring and damper to a wall.
pub fn bob(rate: f64, m: f64, k: f64, z: f64) -> String {
    format!(
        "[rate]\nsound = {rate:?}\n[SOL]\nwall = {{}}\n[MAS]\nbob = {{ m = {m:?} }}\n[REF]\n\
         spring = {{ between = [\"wall\", \"bob\"], k = {k:?}, z = {z:?} }}\n[SOX]\nout = {{ from = \"bob\" }}\n"
    )
}

/// A string given by masses, and stiffness and viscosity of its links.
pub fn string(n: usize, m: f64, k: f64, z: f64) -> String {
    format!("[STRING]\ns = {{ n = {n}, m = {m:?}, k = {k:?}, z = {z:?} }}\n[SOX]\nout = {{ from = \"s[0]\" }}\n")
}

pub fn at(scene: &Scene, place: usize, x: f64, d: f64) -> State {
    let mut s = scene.state();
    (s.x[place], s.d[place]) = (x, d);
    s
}

/// Frequency of a mode whose shape is an eigenvector, from one tick: λ = −⟨d, φ⟩/⟨φ, φ⟩, sin(θ/2) = √λ/2. Also returns
/// the largest deviation from the shape.
pub fn mode(scene: &Scene, places: &[usize], shape: &[f64]) -> (f64, f64) {
    let mut s = scene.state();
    s.d.fill(0.0);
    for (p, v) in places.iter().zip(shape) {
        s.x[*p] = *v;
    }
    tick(scene, &mut s);
    let d: Vec<f64> = places.iter().map(|p| s.d[*p]).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let lambda = -dot(&d, shape) / dot(shape, shape);
    let along: Vec<f64> = shape.iter().map(|v| -lambda * v).collect();
    (lambda, apart(&d, &along))
}

pub fn warped_frequency(lambda: f64, rate: f64) -> f64 {
    rate / PI * (0.5 * lambda.sqrt()).asin()
}
