//! What of a layout belongs to masses that go by their modes.

/// A mass in a group that goes by its modes: a MAT without mass, the sum of its shares in modes that stand in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct Modal {
    /// its own place among the MATs
    pub mat: u32,
    /// place of the first mode
    pub first: u32,
    /// first of its shares in [`Places::shares`](super::Places::shares); how many: [`Modal::n`]
    pub share: u32,
    /// number of modes
    pub n: u32,
}

/// A mass that goes by its modes and at which a link counts on the motion to come (`stable`, `secant`, `newton`, `set-valued`):
/// its place has the mobility of all its modes together as a coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct SolvedModal {
    /// index into [`Places::modal`](super::Places::modal)
    pub modal: u32,
    /// its own place among the MATs
    pub mat: u32,
    /// first of [`SolvedModal::TAPS`] numbers in passing, an index into [`LinkState::tap`](crate::state::State)
    pub tap: u32,
}

impl SolvedModal {
    /// The force on it by all that is explicit, the force that would move it as its modes move by themselves, and its
    /// response to contacts that are solved together.
    pub const TAPS: usize = 3;
}

/// Several of them in one group, whose contacts are solved together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize))]
pub struct ModalCoupling {
    /// the first, an index into [`Places::solved_modal`](super::Places::solved_modal)
    pub first: u32,
    /// how many follow each other
    pub n: u32,
    /// first number in [`Places::couplings`](super::Places::couplings), row by row (n x n)
    pub numbers: u32,
}
