//! Groups at the gesture rate, as the sound side sees them.
//!
//! All such groups are one separate layout with its own passes, whose tick is a gesture frame. Laws, batches and
//! ledgers are thus reused unchanged. The state of the scene holds copies of their MATs, which move from outside like
//! device ports, so that links across, outputs and names find them.

use super::Layout;
use crate::numeric::Real;
use crate::op::Op;
use alloc::vec::Vec;

/// A MAT of a group and its copy in the state of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Copied {
    /// slot in the state of the group
    pub own: u32,
    /// slot in the state of the scene
    pub at: u32,
}

/// Response of the sound side in a frame, linear in what is known at its start. The numbers of a port are a row.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Response {
    /// slots in the state of the scene whose position and motion matter (any)
    pub places: Vec<u32>,
    /// mean force on each port if it does not move \[N\], without the part due to the force at the start of the frame:
    /// a constant, then for each of `places` the force per metre and per metre per tick (coupled × (1 + 2 places))
    pub known: Vec<f64>,
    /// mean force due to the motion of the ports: N on each port per metre that each port would move without this
    /// force. Half of the motion that the force itself adds is included (coupled × coupled)
    pub answer: Vec<f64>,
}

/// The groups at the gesture rate.
#[derive(Clone, Default)]
pub struct SlowGroup<R: Real = f64> {
    /// their arrays; the tick is a gesture frame
    pub layout: Layout<R>,
    /// passes of their ledger, if there is one
    pub reads: Vec<Op<R>>,
    /// passes of the forces within them
    pub forces: Vec<Op<R>>,
    /// passes that need all forces on them
    pub after: Vec<Op<R>>,
    /// passes of integration
    pub moves: Vec<Op<R>>,
    /// MATs whose copies move in every tick; those that links across the border join come first
    pub ports: Vec<Copied>,
    /// number of MATs that links across the border join
    pub coupled: usize,
    /// true if not all forces of these links in a frame are known when it begins
    pub compensated: bool,
    /// MATs whose copies are only read, once per frame
    pub shown: Vec<Copied>,
    /// number of links within them
    pub links: usize,
    /// number of their masses
    pub masses: usize,
    /// response of the links across the border
    pub response: Response,
}
