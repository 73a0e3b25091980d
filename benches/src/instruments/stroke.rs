//! Settings for playing an instrument with a simulated device, by the built-in gesture of its model.
//!
//! The hand of the simulated device follows the built-in gesture, scaled to the hand, not a separate script. The test
//! thus finds a gesture beyond the travel of a hand, and shows by how much a gesture is too fast for the guard.

/// Requirements on an instrument played by a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Largest force while forces begin, as a share of the largest force of the device, for a hand that carries a
    /// weight; 0 for the value of the profile.
    pub clear: f64,
    /// Duration, from before forces come \[s\].
    pub seconds: f64,
    /// Factor on the duration of the built-in gesture, for a mallet that is faster than the guard of the device allows.
    pub slower: f64,
    /// Motions of degrees of freedom without a built-in gesture: times \[s\] and positions \[m\], scaled to the hand.
    pub motions: &'static [(u32, &'static [[f64; 2]])],
    /// Least peak of the sound \[dBFS\].
    pub min_peak: f64,
    /// Least force at the hand \[N\].
    pub min_force: f64,
}

impl Stroke {
    /// Settings for most instruments.
    pub const DEFAULT: Stroke =
        Stroke { clear: 0.0, slower: 1.0, seconds: 5.0, motions: &[], min_peak: -40.0, min_force: 0.05 };
}
