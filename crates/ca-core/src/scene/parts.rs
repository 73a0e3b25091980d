//! The parts of a scene: passes, names of outputs, statements of the author, the model at a device.

use super::Coupling;
use crate::equivalence::Equivalence;
use crate::numeric::Real;
use crate::op::Op;
use alloc::string::String;
use alloc::vec::Vec;

/// The passes of a tick.
#[derive(Clone, Default)]
pub struct Passes<R: Real = f64> {
    /// passes before the forces: ports, ledger, changes, moving points
    pub reads: Vec<Op<R>>,
    /// passes that sum forces at the present positions, then the rows that `moves` sum (see [`Passes::fused`])
    pub forces: Vec<Op<R>>,
    /// number of passes at the end of `forces` that a pass of `moves` runs and integrates in their place
    pub fused: usize,
    /// passes that write outputs
    pub writes: Vec<Op<R>>,
    /// passes that move the MATs
    pub moves: Vec<Op<R>>,
    /// true if links are summed, or masses stored, in another order than in arithmetic 2, so that rows are found
    pub sorted: bool,
}

/// The names of the outputs of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputNames {
    /// names of the sound channels (channels)
    pub channel_names: Vec<String>,
    /// names of the probes (n_out − channels): the selector, or its module if several, with `.x`, `.y`, `.z` in space
    pub probe_names: Vec<String>,
    /// index of the selector of each probe, in the list given to the compiler
    pub probe_of: Vec<u32>,
}

/// Statements of the author about a model, and notes of the compiler.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// title of the model
    pub title: String,
    /// duration that the author gives for it \[s\], if any
    pub seconds: Option<f64>,
    /// built-in gesture of the model: inputs with their points \[s, value\]
    pub gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// presets by name: live parameters and their values (SI)
    pub presets: Vec<(String, Vec<(String, f64)>)>,
    /// descriptions of what the compiler left out
    pub left_out: Vec<String>,
}

/// As the name of a parameter that is set, it chooses a preset: the value is the name of the preset.
pub const PRESET: &str = "preset";

/// A model at a device.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InHand {
    /// size and weight of the model at the device
    pub equivalence: Equivalence,
    /// device ports with a virtual coupling to their links
    pub couplings: Vec<Coupling>,
}

impl<R: Real> Passes<R> {
    /// Returns the passes of [`Passes::forces`] that a tick runs.
    pub fn summed(&self) -> &[Op<R>] {
        &self.forces[..self.forces.len() - self.fused]
    }
}
