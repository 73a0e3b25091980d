//! Outputs: what they hear, channel by channel, and their high pass.

use crate::law::Force;
use crate::numeric::Real;
use crate::op::Law;

/// What an output hears.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Tap {
    /// displacement of a MAT from its rest position; of outputs that hear motion, how far it went in the last tick
    Position(u32),
    /// summed force on a MAT
    ForceOn(u32),
    /// force of a LIA, at this index of [`LinkState::tap`](crate::state::State)
    ForceOf(u32),
}

/// A linear link of a fused pass whose force is heard.
#[derive(Clone, Copy)]
pub struct HeardLink<R: Real = f64> {
    /// its law
    pub law: &'static Law,
    /// the force of its law
    pub force: Force<R>,
    /// slots of its ends
    pub ends: [u32; 2],
    /// constant part of its elongation \[m\]
    pub e0: R,
    /// index of its first coefficient, and from one to the next
    pub coef: u32,
    /// see `coef`
    pub step: u32,
    /// how many it has
    pub coefs: u32,
    /// index into [`LinkState::tap`](crate::state::State), where its force is left
    pub tap: u32,
}

/// An output or a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// index into [`State::output`](crate::state::State)
    pub channel: u32,
    /// what it hears
    pub tap: Tap,
}

/// The outputs of a channel, which follow each other in [`OutputArrays::outputs`](super::OutputArrays::outputs).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct OutputRow {
    /// index into [`State::output`](crate::state::State)
    pub channel: u32,
    /// how many
    pub n: u32,
    /// the first slot of what they hear, where that is many positions that follow each other
    pub first: Option<u32>,
}

/// The high pass of an output, y ← r·y + g·(v − v′).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct DcBlocker<R: Real = f64> {
    /// what stays of y each tick
    pub r: R,
    /// gain
    pub g: R,
}
