//! The parts of a scene: its passes, the names of its outputs, the words of the author, the model in the hand.

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
    /// how many of the last of `forces` no tick runs by themselves, since a pass of `moves` sums them and integrates
    pub fused: usize,
    /// passes that write outputs
    pub writes: Vec<Op<R>>,
    /// passes that move the MATs
    pub moves: Vec<Op<R>>,
    /// links are summed, or masses stand, in another order than by arithmetic 2, so that rows are found
    pub sorted: bool,
}

/// The names of the outputs of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputNames {
    /// names of the sound channels (channels)
    pub channel_names: Vec<String>,
    /// names of the probes (n_out − channels): the selector, or the module where it chose several, with `.x`, `.y`, `.z`
    /// for what is in space
    pub probe_names: Vec<String>,
    /// for each of them the selector that asked for it, a place in the list that the compiler was given
    pub probe_of: Vec<u32>,
}

/// The words of the author about a model, and the notes of the compiler.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// title of the model
    pub title: String,
    /// how long the author lets it sound \[s\], if said
    pub seconds: Option<f64>,
    /// the built-in gesture of the model: what it drives and its points \[s, value\]
    pub gestures: Vec<(String, Vec<[f64; 2]>)>,
    /// what the passes of the compiler left out, in words
    pub left_out: Vec<String>,
}

/// A model in the hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InHand {
    /// how large and heavy the model is in the hand
    pub equivalence: Equivalence,
    /// device ports that are coupled to their links
    pub couplings: Vec<Coupling>,
}

impl<R: Real> Passes<R> {
    /// The passes of [`Passes::forces`] that a tick runs by themselves.
    pub fn summed(&self) -> &[Op<R>] {
        &self.forces[..self.forces.len() - self.fused]
    }
}
