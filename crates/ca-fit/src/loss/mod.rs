//! Loss of a fit: distance of model and recording, by levels in bands ([`spectral`]) or by samples ([`wave`]).
//!
//! Loudness and the time of the onset do not belong to the instrument, so gain and delay are unknowns of every
//! comparison. Both cost no render, since their effect on a sound is known.

pub(super) mod spectral;
pub(super) mod wave;

use super::target::Samples;

/// Gain and delay of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Free {
    pub gain: f64,
    /// Delay of the model \[samples\].
    pub delay: f64,
}

/// Distance of two sounds, as residuals whose squares are summed.
pub(super) trait Loss {
    fn residual(&self, heard: &Samples, free: Free) -> Vec<f64>;
    /// Returns the best gain for a delay, where the gain is free.
    fn settle(&self, heard: &Samples, free: Free) -> Free;
    /// True for gain and delay that are unknowns.
    fn free(&self) -> [bool; 2];
    /// Index of the stretch of time of each residual.
    fn stretches(&self) -> Vec<usize>;
}

/// Number of stretches of time; residuals within one are taken as correlated.
pub(super) const STRETCHES: usize = 20;
