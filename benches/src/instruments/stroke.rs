//! How a simulated device plays an instrument: by the gesture that its model has built in.
//!
//! Decides that the hand of the simulated device follows the gesture itself, in the lengths of the hand, rather than a script with
//! numbers of its own: so a built-in gesture that no hand could play, by its travel, is found out, and one that is too fast for the
//! guard says by how much.

/// What is asked of an instrument that is played by a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// part of the largest force of the device that may press while forces begin, where the instrument has a weight that the
    /// hand carries; that of the profile of the device where 0
    pub clear: f64,
    /// how long it plays, from before forces come \[s\]
    pub seconds: f64,
    /// how many times slower than the gesture that is built in the hand goes, where a mallet is swung faster than the guard of
    /// the device lets a hand go
    pub slower: f64,
    /// where degrees of freedom go, as times \[s\] and places \[m\] in the lengths of the hand, where the model has no gesture of
    /// theirs built in
    pub ways: &'static [(u32, &'static [[f64; 2]])],
    /// least peak that must be heard \[dBFS\]
    pub heard: f64,
    /// least force that must be felt \[N\]
    pub felt: f64,
}

impl Stroke {
    /// What suits most.
    pub const DEFAULT: Stroke = Stroke { clear: 0.0, slower: 1.0, seconds: 5.0, ways: &[], heard: -40.0, felt: 0.05 };
}
