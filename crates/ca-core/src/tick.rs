//! The tick: inputs → changes → forces at x_n → outputs → advance, and its public halves.

use crate::scene::Scene;
use crate::state::State;

/// Runs one tick: inputs → changes → forces at x_n → outputs → advance.
pub fn tick(scene: &Scene, s: &mut State) {
    sense(scene, s);
    advance(scene, s);
}

/// The first half of a tick: reads inputs, sums the forces at x_n and writes the outputs. What a device must get of
/// this tick is known here, before any mass moves.
pub fn sense(scene: &Scene, s: &mut State) {
    for op in scene.reads.iter().chain(&scene.forces).chain(&scene.writes) {
        (op.kernel)(op, &scene.layout, s);
    }
}

/// The second half of a tick: moves the masses from x_n to x_{n+1}.
pub fn advance(scene: &Scene, s: &mut State) {
    for op in &scene.moves {
        (op.kernel)(op, &scene.layout, s);
    }
    s.tick += 1;
}

/// Runs `out.len() / n_out` ticks and writes their outputs, interleaved. Inputs keep the values they have.
pub fn process(scene: &Scene, s: &mut State, out: &mut [f64]) {
    for frame in out.chunks_exact_mut(scene.n_out.max(1)) {
        tick(scene, s);
        for (o, v) in frame.iter_mut().zip(&s.output) {
            *o = *v;
        }
    }
}
