//! Equivalence: how large and how heavy the simulated world is in the hand.
//!
//! X = α·x from real to simulated position, f = β·F from simulated to real force (GENESIS paper, 6.3; numerics 6). Per
//! key the two are tuned: together they are a lever, apart an amplifier of energy.

/// Between the real and the simulated world, for one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains {
    /// simulated metres per real metre
    pub alpha: f64,
    /// real newtons per simulated newton
    pub beta: f64,
}

impl Default for Gains {
    fn default() -> Gains {
        Gains { alpha: 1.0, beta: 1.0 }
    }
}
