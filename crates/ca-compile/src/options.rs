//! What the caller asks of a compilation.

use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Precision;
use ca_core::internal::kind::cloud::Clouds;
use ca_core::internal::scene::Coupling;

/// Which passes run the links.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KernelClass {
    /// batches by law, chains as runs: fast
    #[default]
    Fast,
    /// the same batches, each as a pass of its own: what `Fast` joins, folds and fuses must have the bits of these
    Listed,
    /// links one by one in document order: the bits of a plain loop over modules
    Reference,
}

/// How far a scene is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effort {
    /// by cheap bounds
    Bounds,
    /// by a factorisation, where they leave it open
    Open,
    /// with the largest eigenvalue
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

/// What the caller asks of a compilation.
#[derive(Clone, Debug, Default)]
#[allow(clippy::struct_excessive_bools, reason = "each is asked for by itself")]
pub struct Options {
    /// sound rate \[Hz\]; the model's own if `None`
    pub rate: Option<f64>,
    /// keep the energy ledger
    pub energy: bool,
    /// make the scene without a ledger and with it, [`Compiled::audited`](crate::Compiled::audited): what takes long, the modes
    /// of a large scene above all, is computed once for both
    pub audited: bool,
    /// selectors of modules to be heard besides the outputs: displacement of a MAT, force of a LIA
    pub probes: Vec<String>,
    /// what the files named in the model hold
    pub clouds: Clouds,
    /// narrow down the largest eigenvalue, where the build can
    pub exact: bool,
    /// judge stability by cheap bounds alone, without a factorisation: for who has judged such a scene before
    pub bounds_only: bool,
    /// which passes run the links
    pub kernel: KernelClass,
    /// keep what nothing hears: somebody looks at it
    pub whole: bool,
    /// device ports that are coupled to their links, since their device cannot render these
    pub couplings: Vec<Coupling>,
    /// the number that the scene is bound to ([`Scene::bind`](ca_core::Scene::bind)): in single precision what that does not keep is
    /// refused, and only for double precision kernels in vectors are taken
    pub precision: Precision,
    /// begin as by this older [`ca_core::ARITHMETIC`], for takes; as by the one of now if `None`
    pub arithmetic: Option<u32>,
}
