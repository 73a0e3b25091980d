//! Options of a compilation.

use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Precision;
use ca_core::internal::kind::cloud::Clouds;
use ca_core::internal::scene::Coupling;

/// Kernels that run the links.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelClass {
    /// Batches by law, with chains as runs: the fast form.
    #[default]
    Fast,
    /// The same batches, each as a separate pass. `Fast` joins, folds and fuses them and must have the same bits.
    Listed,
    /// Links one by one in document order: the bits of a plain loop over the modules.
    Reference,
}

/// Depth of the stability analysis of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// Cheap bounds only.
    Bounds,
    /// A factorisation where the bounds do not decide.
    Open,
    /// A factorisation, and the largest eigenvalue.
    Largest,
}

impl Options {
    pub(crate) fn effort(&self) -> Effort {
        match (self.exact, self.bounds_only) {
            (true, _) => Effort::Largest,
            (false, true) => Effort::Bounds,
            (false, false) => Effort::Open,
        }
    }
}

/// Options of a compilation.
#[derive(Clone, Debug, Default)]
#[allow(clippy::struct_excessive_bools, reason = "each is asked for by itself")]
pub struct Options {
    /// Sound rate \[Hz\]; `None` takes the rate of the model.
    pub rate: Option<f64>,
    /// Adds the energy ledger to the scene.
    pub energy: bool,
    /// Compiles a second scene, with the ledger: [`Compiled::audited`](crate::Compiled::audited). Expensive steps,
    /// above all the modes of a large scene, run once for both.
    pub audited: bool,
    /// Selectors of modules to record besides the outputs: the displacement of a MAT or the force of a LIA.
    pub probes: Vec<String>,
    /// Contents of the files named in the model.
    pub clouds: Clouds,
    /// Computes the largest eigenvalue, if the build has the feature `analysis`.
    pub exact: bool,
    /// Judges stability by cheap bounds only, without a factorisation: for a scene that was judged before.
    pub bounds_only: bool,
    /// Kernels that run the links.
    pub kernel: KernelClass,
    /// Keeps modules that no output depends on, e.g. to display them.
    pub whole: bool,
    /// Device ports to couple to their links virtually, because their device cannot render these links directly.
    pub couplings: Vec<Coupling>,
    /// Number type that the scene is bound to ([`Scene::bind`](ca_core::Scene::bind)). For single precision, models
    /// that lose too much by it are refused, and no vector kernels are used.
    pub precision: Precision,
    /// [`ca_core::ARITHMETIC`] version to compile for, taken from an older take; `None` means the present version.
    pub arithmetic: Option<u32>,
}

impl Options {
    /// Returns whether the compiler works as from this arithmetic version on.
    pub(crate) fn is_since(&self, arithmetic: u32) -> bool {
        self.arithmetic.is_none_or(|a| a >= arithmetic)
    }
}
