//! Halves: one scene as two, for two threads.
//!
//! Decides that a half is a scene like any other, beside lists of places: between two ticks somebody writes the positions
//! and motions of its ghosts, MATs that move in the other half. The compiler says which (`ca-compile`, `split`), and
//! whoever plays them carries the numbers over (`ca-io`, `halves`).

use crate::scene::Scene;
use alloc::vec::Vec;

/// One of two halves of a scene.
#[derive(Debug)]
pub struct Half {
    /// what runs; its certificate and its names are those of the whole
    pub scene: Scene,
    /// for each place of its outputs the place in those of the whole, or `None` where the other half writes it (n_out)
    pub outputs: Vec<Option<u32>>,
    /// places of a number here and in the whole scene, for all MATs of this half, ghosts too: [`State::x`](crate::State::x) and `d`
    pub places: Vec<[u32; 2]>,
    /// the same, only of those that move here by themselves
    pub own: Vec<[u32; 2]>,
    /// places that the other half has ghosts of; as many as its [`Half::ghosts`], in the same order
    pub shared: Vec<u32>,
    /// places of the ghosts here
    pub ghosts: Vec<u32>,
}

/// A scene in two halves.
#[derive(Debug)]
pub struct Halves {
    /// the halves
    pub halves: [Half; 2],
    /// share of the work in the larger half, links across the cut counted in both: 0.5 is the best there is
    pub share: f64,
    /// links across the cut
    pub across: usize,
}
