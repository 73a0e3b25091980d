//! Layout of modal masses.

/// A modal mass: a MAT without inertia whose position is the weighted sum of consecutive modes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Modal {
    /// slot of the mass
    pub mat: u32,
    /// slot of the first mode
    pub first: u32,
    /// first of its [`Modal::n`] shares in [`Places::shares`](super::Places::shares)
    pub share: u32,
    /// number of modes
    pub n: u32,
}

/// A modal mass with a link that is solved with the coming motion (`stable`, `secant`, `newton`, `set-valued`). The
/// coefficient of its slot is the mobility of all its modes together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct SolvedModal {
    /// index into [`Places::modal`](super::Places::modal)
    pub modal: u32,
    /// slot of the mass
    pub mat: u32,
    /// first of [`SolvedModal::TAPS`] temporary numbers, an index into [`LinkState::tap`](crate::state::State)
    pub tap: u32,
}

impl SolvedModal {
    /// Number of temporary numbers: the sum of explicit forces on the mass, the force equivalent to the motion of its
    /// modes by themselves, and its response to contacts that are solved together.
    pub const TAPS: usize = 3;
}

/// Several such masses in one group, whose contacts are solved together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct ModalCoupling {
    /// index of the first in [`Places::solved_modal`](super::Places::solved_modal)
    pub first: u32,
    /// number of consecutive masses
    pub n: u32,
    /// first number in [`Places::couplings`](super::Places::couplings), row by row (n x n)
    pub numbers: u32,
}
