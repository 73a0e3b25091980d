//! Methods: implicit linear links ([`implicit`], docs/numerics.md §3.1), a tick of fourth order for the whole model
//! ([`pefrl`], §3.1), one-sided springs that conserve energy at any stiffness (§3.3, §3.4), and friction that only
//! resists at any steepness (§3.5).
//!
//! The rest of this page is about contacts and friction. The explicit contact makes or loses energy at every impact
//! (docs/numerics.md §3.2), because its force is the one at the beginning of a tick. The methods here choose the force
//! so that its work over the tick equals the energy that the spring stores. This needs the motion that all *other*
//! forces would cause, so their passes come last (see [`SolveStage`](crate::op::SolveStage)). Sub-steps, or iteration
//! of the whole scene, would cost in every tick; these methods cost only while something touches.
//!
//! All springs share these definitions. The penetration η is `side·(d − e)`, positive while compressed. The push N ≥ 0
//! acts against it; as a tension of the link it is F = −side·N. A push N over a tick takes the work N·s/2 from the
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
mod sweeps;
mod system;
pub(crate) mod together;

use crate::numeric::Real;
use crate::op::layout::Layout;
use crate::state::State;

/// Returns the change of position \[m/tick\] that all forces so far give to a slot in this tick. A port that runs a
/// tick late moves to its next position; any other port continues its motion.
#[inline(always)]
pub fn free_motion<R: Real>(layout: &Layout<R>, s: &State<R>, slot: usize) -> R {
    let n = layout.counts.n_mat;
    let goes = s.coef[slot] * s.d[slot] + s.coef[n + slot] * s.x[slot] + s.coef[2 * n + slot] * s.f[slot];
    match s.ports.turns.get(slot) {
        Some(turns) => goes + *turns,
        None => goes,
    }
}

/// Returns the mobility T²/m of a slot \[m/N\].
#[inline(always)]
pub fn mobility<R: Real>(layout: &Layout<R>, s: &State<R>, slot: usize) -> R {
    s.coef[2 * layout.counts.n_mat + slot]
}
