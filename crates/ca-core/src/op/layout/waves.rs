//! Waves: the ways of waveguides, and where they are touched.

use crate::numeric::Real;
use crate::tuning::wave::Loss;
use alloc::vec::Vec;

/// A place where a waveguide is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Junction<R: Real = f64> {
    /// the MAT it is
    pub mat: u32,
    /// wave impedance of either side \[N per m/tick\]
    pub z: R::Outer,
    /// its memory: the waves that arrive from either side, and its motion before the tick \[m/tick\]
    pub memory: usize,
}

/// What a wave meets at the end of its way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub enum Termination<R: Real = f64> {
    /// nothing: on to the next junction
    Open,
    /// a rigid end
    Rigid,
    /// a rigid end with a loss and an allpass
    Lossy {
        /// their coefficients
        loss: Loss<R::Outer>,
        /// memory of the allpass
        memory: usize,
    },
}

/// A way that waves take, from one side of a junction to a side of the same or of the next: a ring of waves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Delay<R: Real = f64> {
    /// the junction they leave
    pub junction: usize,
    /// memory of the wave that arrives on the side they leave from
    pub from: usize,
    /// memory of the wave that arrives on the side they come to
    pub to: usize,
    /// first slot of the ring
    pub first: usize,
    /// its length: the ticks a wave takes, and three more where a loss follows
    pub len: usize,
    /// what they meet at its end
    pub end: Termination<R>,
}

/// The waveguides of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Waves<R: Real = f64> {
    /// where they are touched (any)
    pub junctions: Vec<Junction<R>>,
    /// how waves travel (any)
    pub delays: Vec<Delay<R>>,
    /// first slot of their memory in [`LinkState::mem`](crate::state::State)
    pub first: usize,
    /// places of it
    pub len: usize,
}
