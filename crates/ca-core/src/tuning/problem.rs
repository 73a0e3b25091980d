//! Problem: why parameters that make sense one by one have no solution together.

use alloc::string::String;

/// Why a generator cannot do what was asked.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// one line
    pub title: String,
    /// the parameter to point at
    pub param: &'static str,
    /// what to do
    pub help: String,
}
