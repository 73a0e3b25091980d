//! Slow groups: what is computed once a gesture frame, as the sound side sees it.
//!
//! Decides that all groups at the gesture rate are one layout of their own, with passes of its own: every law, batch and
//! ledger is there at another tick, and nothing of it had to be written twice. Of its MATs the state of the scene holds
//! copies that move from outside, as device ports do, so that links across, outputs and names find them.

use super::Layout;
use crate::numeric::Real;
use crate::op::Op;
use alloc::vec::Vec;

/// A place of a group and its copy in the state of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Copied {
    /// place in the state of the group
    pub own: u32,
    /// place in the state of the scene
    pub at: u32,
}

/// What the sound side answers in a frame, as linear functions of what is known as it begins. Numbers of a port stand in a row.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Response {
    /// places in the state of the scene whose position and motion count (any)
    pub places: Vec<u32>,
    /// mean force on each port that stays where it is \[N\], but for the force that the frame began with: what is always there,
    /// then for each of `places` what a metre there adds, and what a metre per tick does (coupled × (1 + 2 places))
    pub known: Vec<f64>,
    /// what of the mean force comes of the ports' own motion, the half of what that force adds to it included: for
    /// each \[N\] by the motion of each that there would be without it \[m\] (coupled × coupled)
    pub answer: Vec<f64>,
}

/// The groups at the gesture rate.
#[derive(Clone, Default)]
pub struct SlowGroup<R: Real = f64> {
    /// its arrays; the tick is a gesture frame
    pub layout: Layout<R>,
    /// its ledger, where there is one
    pub reads: Vec<Op<R>>,
    /// forces within it
    pub forces: Vec<Op<R>>,
    /// what looks at all forces on it
    pub after: Vec<Op<R>>,
    /// integration
    pub moves: Vec<Op<R>>,
    /// places whose copies move in every tick; those that links across hold come first
    pub ports: Vec<Copied>,
    /// how many links across hold
    pub coupled: usize,
    /// true where not all that these links do in a frame is known as it begins
    pub compensated: bool,
    /// places whose copies are only looked at, once a frame
    pub shown: Vec<Copied>,
    /// links within it
    pub links: usize,
    /// masses of it
    pub masses: usize,
    /// what the links across answer
    pub response: Response,
}
