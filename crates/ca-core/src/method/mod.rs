//! Methods: implicit linear links ([`implicit`], docs/numerics.md §3.1), a tick of fourth order for the whole model
//! ([`pefrl`], §3.1), one-sided springs that keep energy exact whatever their stiffness (§3.3, §3.4), and friction that
//! only resists however steep it is (§3.5). The rest of this page speaks of the last two.
//!
//! The explicit contact makes or loses energy at every blow (docs/numerics.md §3.2), because its force is that at
//! the beginning of a tick. The methods here choose the force so that its work over the tick is what the spring takes
//! up, which needs the motion that all *other* forces would cause: their passes come last among the forces (see
//! [`SolveStage`](crate::op::SolveStage)). Decides against sub-steps and against iterating the whole scene: both cost in
//! every tick, these only while something touches.
//!
//! Common to the springs: the penetration η is `side·(d − e)`, positive while pressed together; the push N ≥ 0 acts
//! against it, and as a tension of the link it is F = −side·N. A push N kept over a tick takes the work N·s/2 from the
//! masses, where s = η₊ − η₋ is the change of penetration over two ticks (docs/numerics.md §2.2).

pub(crate) mod cluster;
pub mod coulomb;
pub mod friction;
pub(crate) mod gradient;
pub mod implicit;
pub mod modes;
mod newton;
pub mod pefrl;
pub(crate) mod potential;
pub mod quadratised;
pub(crate) mod spring;
mod system;
pub(crate) mod together;

use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// The change of position \[m/tick\] that all forces so far give to a slot in this tick. A port goes where it was read to go, if it
/// runs a tick late, or else on as it went.
pub fn free_motion<R: Real>(layout: &Layout<R>, s: &State<R>, slot: usize) -> R {
    let n = layout.counts.n_mat;
    let goes = s.coef[slot] * s.d[slot] + s.coef[n + slot] * s.x[slot] + s.coef[2 * n + slot] * s.f[slot];
    match s.ports.turns.get(slot) {
        Some(turns) => goes + *turns,
        None => goes,
    }
}

/// Mobility T²/m of a slot \[m/N\].
pub fn mobility<R: Real>(layout: &Layout<R>, s: &State<R>, slot: usize) -> R {
    s.coef[2 * layout.counts.n_mat + slot]
}
