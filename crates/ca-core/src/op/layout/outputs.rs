//! Layout of outputs: the signals they read, channel by channel, and their high-pass filters.

use crate::law::Force;
use crate::numeric::Real;
use crate::op::Law;

/// Signal that an output reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub enum Tap {
    /// displacement of a MAT from its rest position; for outputs of motion, its change in the last tick
    Position(u32),
    /// sum of the forces on a MAT
    ForceOn(u32),
    /// force of a LIA, at this index of [`LinkState::tap`](crate::state::State)
    ForceOf(u32),
}

/// A linear link of a fused pass whose force an output reads.
#[derive(Clone, Copy)]
pub struct OutputLink<R: Real = f64> {
    /// law of the link
    pub law: &'static Law,
    /// force function of the law
    pub force: Force<R>,
    /// slots of its ends
    pub ends: [u32; 2],
    /// constant part of its elongation \[m\]
    pub e0: R,
    /// index of its first coefficient; the others follow at intervals of `step`
    pub coef: u32,
    /// see `coef`
    pub step: u32,
    /// number of coefficients
    pub coefs: u32,
    /// index into [`LinkState::tap`](crate::state::State) that receives its force
    pub tap: u32,
}

/// An output or a probe.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Output {
    /// index into [`State::output`](crate::state::State)
    pub channel: u32,
    /// signal that it reads
    pub tap: Tap,
}

/// The outputs of a channel, which are consecutive in [`OutputArrays::outputs`](super::OutputArrays::outputs).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct OutputRow {
    /// index into [`State::output`](crate::state::State)
    pub channel: u32,
    /// number of outputs
    pub n: u32,
    /// first slot, if the outputs read many consecutive positions
    pub first: Option<u32>,
}

/// High-pass of an output: y ← r·y + g·(v − v′).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct DcBlocker<R: Real = f64> {
    /// decay of y per tick
    pub r: R,
    /// gain
    pub g: R,
}
