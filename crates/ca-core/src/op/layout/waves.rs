//! Layout of waveguides: their delays and junctions.

use crate::numeric::Real;
use crate::tuning::wave::Loss;
use alloc::vec::Vec;

/// A junction, where links act on a waveguide.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Junction<R: Real = f64> {
    /// MAT of the junction
    pub mat: u32,
    /// wave impedance of each side \[N per m/tick\]
    pub z: R::Outer,
    /// first number of its memory: the arriving waves of both sides, and its motion before the tick \[m/tick\]
    pub memory: usize,
}

/// End of a delay, as a wave meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub enum Termination<R: Real = f64> {
    /// the next junction
    Open,
    /// a rigid end
    Rigid,
    /// a rigid end with a loss and an allpass
    Lossy {
        /// coefficients of loss and allpass
        loss: Loss<R::Outer>,
        /// memory index of the allpass
        memory: usize,
    },
}

/// A delay: a ring of waves on the way from one side of a junction to a side of the same or the next junction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Delay<R: Real = f64> {
    /// junction that the waves leave
    pub junction: usize,
    /// memory index of the wave that arrives on the side they leave
    pub from: usize,
    /// memory index of the wave that arrives on the side they reach
    pub to: usize,
    /// first slot of the ring
    pub first: usize,
    /// length of the ring: the ticks a wave takes, plus three if a loss follows
    pub len: usize,
    /// what the waves meet at the end
    pub end: Termination<R>,
}

/// The waveguides of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Waves<R: Real = f64> {
    /// junctions (any)
    pub junctions: Vec<Junction<R>>,
    /// delays (any)
    pub delays: Vec<Delay<R>>,
    /// first index of their memory in [`LinkState::mem`](crate::state::State)
    pub first: usize,
    /// length of that memory
    pub len: usize,
}
