//! Verifies each index of a scene against the length of the indexed array.
//!
//! The compiler writes consistent scenes; a file may not be. Kernels, the start and live changes rely on these rules:
//! without each of them some pass would read beyond an array. The work is proportional to the scene: arrays are visited
//! once, passes by their ranges, and links once per pass that runs them.

mod arrays;
mod group;
mod links;
mod live;
mod names;
mod passes;
mod state;

use super::known::Known;
use crate::scene::Scene;
pub(super) use arrays::layout;
pub(super) use group::group;
pub(super) use state::state;

/// A part of a scene that does not fit, as a clause for the message.
pub(super) struct Wrong(pub(super) &'static str);

type Verified = Result<(), Wrong>;

fn ensure(fits: bool, what: &'static str) -> Verified {
    if fits { Ok(()) } else { Err(Wrong(what)) }
}

/// Returns true if `n` entries from `first` on are within `len`.
fn in_bounds(first: usize, n: usize, len: usize) -> bool {
    first.checked_add(n).is_some_and(|end| end <= len)
}

/// Returns true if `rows` times `n` entries from `first` on are within `len`.
fn block(first: usize, rows: usize, n: usize, len: usize) -> bool {
    rows.checked_mul(n).is_some_and(|all| in_bounds(first, all, len))
}

fn each<'a>(all: impl IntoIterator<Item = &'a u32>, len: usize) -> bool {
    all.into_iter().all(|i| (*i as usize) < len)
}

/// Verifies a scene whose layout, states and group have been verified.
pub(super) fn scene(scene: &Scene, known: &Known) -> Verified {
    passes::scene(scene)?;
    names::scene(scene)?;
    live::plan(&scene.live, &scene.layout, scene.initial.ramps.index.len(), known)
}
