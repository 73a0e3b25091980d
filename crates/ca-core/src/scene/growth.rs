//! Measured growth of energy at explicit contacts.
//!
//! An explicit contact makes or takes energy at each impact, depending on the phase (docs/numerics.md §3.2), at any
//! stiffness. `tests/suite/compiler/growth.rs` measured how often energy grew: a ball between two lossless walls, its
//! stiffness drawn up to a factor of √2 around each value, with position and speed drawn too.

/// Number of random starts per stiffness.
pub const STARTS: u32 = 24;
/// Duration of each run \[s\], at 48 kHz.
pub const SECONDS: u32 = 60;
/// Energy relative to load that counts as growth.
pub const TIMES: f64 = 1.5;

/// Growth at one stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// kT²/m
    pub stiffness: f64,
    /// number of the [`STARTS`] whose energy exceeded [`TIMES`] within [`SECONDS`]
    pub grew: u32,
}

/// All measurements.
pub const MEASURED: [Growth; 6] = [
    Growth { stiffness: 0.01, grew: 0 },
    Growth { stiffness: 0.03, grew: 2 },
    Growth { stiffness: 0.1, grew: 14 },
    Growth { stiffness: 0.3, grew: 20 },
    Growth { stiffness: 1.0, grew: 24 },
    Growth { stiffness: 2.0, grew: 24 },
];

impl Growth {
    /// Returns the measurement at the next stiffness from `stiffness` on, or the last one.
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
            "a lossless ball between two walls, played at kT²/m near {stiffness}, exceeded {TIMES} times its initial \
             energy in {grew} of {STARTS} runs of {SECONDS} s"
        )
    }
}
