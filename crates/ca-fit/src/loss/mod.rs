//! The loss of a fit: how far what is heard of the model is from the recording, by levels in bands ([`spectral`]) or sample by
//! sample ([`wave`]).
//!
//! Decides that loudness and the moment of the onset are not of the instrument: a gain and a delay are unknowns of every
//! comparison. Both cost no render, since what they do to a sound is known.

pub(super) mod spectral;
pub(super) mod wave;

use super::target::Samples;

/// Gain and delay of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Free {
    pub gain: f64,
    /// of the model \[samples\]
    pub delay: f64,
}

/// A distance of two sounds, as residuals whose squares are summed.
pub(super) trait Loss {
    /// Residuals.
    fn residual(&self, heard: &Samples, free: Free) -> Vec<f64>;
    /// The best gain for a delay, where it is free.
    fn settle(&self, heard: &Samples, free: Free) -> Free;
    /// Whether gain and delay are unknowns.
    fn free(&self) -> [bool; 2];
    /// The stretch of time of each residual, counted from 0.
    fn stretches(&self) -> Vec<usize>;
}

/// Stretches of time in which residuals hang together.
pub(super) const STRETCHES: usize = 20;
