//! The tick and its public halves. A tick runs the lists of passes of the scene in this order: reads (inputs, changes of
//! parameters), forces at x_n, writes (outputs), moves (integration to x_{n+1}).
//!
//! Each call compares the identities of state and scene once, before any pass. A state of another scene would play
//! wrong numbers, or read beyond an array. A type that binds both would avoid this, but keep the state borrowed.

use crate::numeric::Real;
use crate::op::Op;
use crate::scene::Scene;
use crate::state::State;

/// Steps one sample: reads inputs and changes of parameters, sums the forces at x_n, writes the outputs and integrates.
///
/// # Panics
/// If the state does not belong to this scene (nothing has changed then), or if the length of one of its arrays was
/// changed.
#[inline]
pub fn tick<R: Real>(scene: &Scene<R>, s: &mut State<R>) {
    own(scene, s);
    forces(scene, s);
    motion(scene, s);
}

/// Runs the first half of a tick: reads inputs, sums the forces at x_n and writes the outputs. All that a device gets
/// from this tick is known here, before any mass moves.
///
/// # Panics
/// As [`tick`].
#[inline]
pub fn compute_forces<R: Real>(scene: &Scene<R>, s: &mut State<R>) {
    own(scene, s);
    forces(scene, s);
}

/// Runs the second half of a tick: moves the masses from x_n to x_{n+1}.
///
/// # Panics
/// As [`tick`].
#[inline]
pub fn integrate<R: Real>(scene: &Scene<R>, s: &mut State<R>) {
    own(scene, s);
    motion(scene, s);
}

/// Runs `out.len() / n_out` ticks (`out.len()` without outputs) and writes their outputs, interleaved. Inputs stay as
/// set.
///
/// Returns false, and plays nothing, for a state of another scene or if `out` does not hold whole rows of outputs.
///
/// # Panics
/// If the length of an array of the state was changed.
#[must_use = "false means that nothing was played"]
pub fn process<R: Real>(scene: &Scene<R>, s: &mut State<R>, out: &mut [R::Outer]) -> bool {
    let row = scene.counts.n_out.max(1);
    if s.scene != scene.identity() || !out.len().is_multiple_of(row) {
        return false;
    }
    for frame in out.chunks_exact_mut(row) {
        forces(scene, s);
        motion(scene, s);
        for (o, v) in frame.iter_mut().zip(&s.output) {
            *o = *v;
        }
    }
    true
}

/// Refuses a state of another scene.
#[inline]
fn own<R: Real>(scene: &Scene<R>, s: &State<R>) {
    if s.scene != scene.identity() {
        foreign(scene);
    }
}

#[cold]
#[inline(never)]
fn foreign<R: Real>(scene: &Scene<R>) -> ! {
    let title = &scene.about.title;
    panic!("the state does not belong to the scene `{title}`: make it with `scene.state()` of the scene that is played")
}

#[inline]
fn forces<R: Real>(scene: &Scene<R>, s: &mut State<R>) {
    // list by list: a single iterator over all lists tests at each pass which list it is in
    for list in [&scene.passes.reads[..], scene.passes.summed(), &scene.passes.writes] {
        run(list, scene, s);
    }
}

#[inline]
fn motion<R: Real>(scene: &Scene<R>, s: &mut State<R>) {
    run(&scene.passes.moves, scene, s);
    s.tick += 1;
}

#[inline]
fn run<R: Real>(list: &[Op<R>], scene: &Scene<R>, s: &mut State<R>) {
    for op in list {
        (op.kernel)(op, &scene.layout, s);
    }
}
