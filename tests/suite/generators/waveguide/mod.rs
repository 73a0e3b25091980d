//! Waveguides: pitch and decay from the poles of the running engine (G01), junctions with any spring (G02, G03),
//! propagation, energy ledgers, and instruments that touch a string.

mod junction;
mod ledgers;
mod played;
mod tuning;

use crate::play::TURN;
use ca_core::internal::op::layout::Termination;
use ca_core::{Scene, tick};

/// A string with these parameters at 48 kHz, with its first junction as the output, and `more` model text.
fn string(parameters: &str, more: &str) -> String {
    format!("[WAVEGUIDE]\nw = {{ {parameters} }}\n[SOX]\nout = {{ from = \"w[0]\" }}\n{more}")
}

/// Poles of the running engine as moduli and angles. Each number of the state is perturbed for one tick. Waves in the
/// ring buffers are indexed by their age.
fn poles(scene: &Scene) -> Vec<[f64; 2]> {
    let start = scene.state();
    let places: Vec<usize> = (0..scene.counts.n_mat).filter(|i| start.coef[2 * scene.counts.n_mat + i] > 0.0).collect();
    let waves = &scene.waves;
    let memories = waves.delays.iter().filter_map(|d| match d.end {
        Termination::Lossy { memory, .. } => Some(memory),
        _ => None,
    });
    let mem = |tick: usize| -> Vec<usize> {
        let rings = waves.delays.iter().flat_map(|d| (1..=d.len).map(move |b| d.first + (tick + d.len - b) % d.len));
        rings.chain(memories.clone()).collect()
    };
    let n = 2 * places.len() + mem(0).len();
    let mut map = faer::Mat::<f64>::zeros(n, n);
    for j in 0..n {
        let mut s = start.clone();
        s.x.fill(0.0);
        s.d.fill(0.0);
        match (j / 2, j % 2) {
            (k, 0) if k < places.len() => s.x[places[k]] = 1.0,
            (k, _) if k < places.len() => s.d[places[k]] = 1.0,
            _ => s.links.mem[mem(0)[j - 2 * places.len()]] = 1.0,
        }
        tick(scene, &mut s);
        let motion = places.iter().flat_map(|p| [s.x[*p], s.d[*p]]);
        for (i, v) in motion.chain(mem(1).into_iter().map(|m| s.links.mem[m])).enumerate() {
            map[(i, j)] = v;
        }
    }
    map.eigenvalues().expect("they are found").iter().map(|p| [p.norm(), p.arg()]).collect()
}

/// Frequency \[Hz\] and T60 \[s\] of the pole nearest to `f`.
fn pole(poles: &[[f64; 2]], rate: f64, f: f64) -> (f64, f64) {
    let off = |p: &&[f64; 2]| (p[1] * rate / TURN - f).abs();
    let near = poles.iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("a pole");
    (near[1] * rate / TURN, -3.0 * std::f64::consts::LN_10 / (near[0].ln() * rate))
}

fn radius(poles: &[[f64; 2]]) -> f64 {
    poles.iter().map(|p| p[0]).fold(0.0, f64::max)
}
