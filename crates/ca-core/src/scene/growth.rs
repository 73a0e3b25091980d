//! Measured growth of energy at explicit contacts.
//!
//! An explicit contact makes or takes energy at each blow, depending on the phase (docs/numerics.md §3.2), so no stiffness is
//! without growth. This module holds how often energy grew, measured by `tests/suite/compiler/growth.rs`: a ball
//! between two walls, without losses, its stiffness drawn up to a factor of √2 around each value, place and speed drawn too.

/// Starts that were drawn of each stiffness.
pub const STARTS: u32 = 24;
/// Length of each run \[s\], at 48 kHz.
pub const SECONDS: u32 = 60;
/// Energy over that at load that counts as growth.
pub const TIMES: f64 = 1.5;

/// Growth at one stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// kT²/m
    pub stiffness: f64,
    /// starts of [`STARTS`] whose energy passed [`TIMES`] within [`SECONDS`]
    pub grew: u32,
}

/// All that was measured.
pub const MEASURED: [Growth; 6] = [
    Growth { stiffness: 0.01, grew: 0 },
    Growth { stiffness: 0.03, grew: 2 },
    Growth { stiffness: 0.1, grew: 14 },
    Growth { stiffness: 0.3, grew: 20 },
    Growth { stiffness: 1.0, grew: 24 },
    Growth { stiffness: 2.0, grew: 24 },
];

impl Growth {
    /// The measurement at the next stiffness from `stiffness` on, or the last.
    pub fn near(stiffness: f64) -> Growth {
        let last = MEASURED[MEASURED.len() - 1];
        MEASURED.into_iter().find(|g| g.stiffness >= stiffness).unwrap_or(last)
    }
}

impl core::fmt::Display for Growth {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Growth { stiffness, grew } = self;
        write!(
            f,
            "at {stiffness}, energy passed {TIMES} times that at load in {grew} of {STARTS} starts within {SECONDS} s"
        )
    }
}
