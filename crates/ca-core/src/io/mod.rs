//! Ports: the doors between a scene and the outside.

use crate::kind::Kind;

pub mod midi;

/// What a port does each tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortRole {
    /// position in: a MAT moved from outside, once per sound sample
    Enx,
    /// force in: added to the force on a MAT, once per sound sample
    Enf,
    /// position out
    Sox,
    /// force out
    Sof,
    /// one degree of freedom of a device: position in, force out, across the rate border
    Tgr,
}

/// All port kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[];
