//! Verify: each index of a scene against the length of what it indexes.
//!
//! A compiler writes scenes that fit; a file need not. Kernels, the start and live changes rely on these rules: each rule follows
//! from a pass that would read beyond an array. The work is in proportion to the scene: arrays
//! are looked at once, passes by their ranges, and links once for each pass that runs them.

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

/// A part of a scene that does not fit, as a clause.
pub(super) struct Wrong(pub(super) &'static str);

type Verified = Result<(), Wrong>;

/// Refuses what is not `true`.
fn ensure(fits: bool, what: &'static str) -> Verified {
    if fits { Ok(()) } else { Err(Wrong(what)) }
}

/// True where `n` entries from `first` on are among `len`.
fn within(first: usize, n: usize, len: usize) -> bool {
    first.checked_add(n).is_some_and(|end| end <= len)
}

/// True where `rows` times `n` entries from `first` on are among `len`.
fn block(first: usize, rows: usize, n: usize, len: usize) -> bool {
    rows.checked_mul(n).is_some_and(|all| within(first, all, len))
}

/// True where each of `all` is an index into `len` entries.
fn each<'a>(all: impl IntoIterator<Item = &'a u32>, len: usize) -> bool {
    all.into_iter().all(|i| (*i as usize) < len)
}

/// A scene whose layout, states and group have been verified.
pub(super) fn scene(scene: &Scene, known: &Known) -> Verified {
    passes::scene(scene)?;
    names::scene(scene)?;
    live::plan(&scene.live, &scene.layout, scene.initial.ramps.index.len(), known)
}
