//! Generators: one line of text, many modules.

use crate::kind::Kind;

/// A generator (filled in by the compiler).
#[derive(Clone, Copy)]
pub struct Generator {
    /// its code
    pub code: &'static str,
}

/// All generator kinds, in the order of the documentation.
pub const KINDS: &[&Kind] = &[];
