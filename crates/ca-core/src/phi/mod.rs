//! LIA: the laws of interaction between two MATs.

use crate::kind::Kind;

/// A law, ready to be run (filled in by the kernels).
#[derive(Clone, Copy)]
pub struct Law {
    /// its code
    pub code: &'static str,
}

/// All LIA kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[];
