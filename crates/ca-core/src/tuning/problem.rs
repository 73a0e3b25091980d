//! The error for parameters that make sense one by one but cannot be met together.

use alloc::string::String;

/// Why a generator cannot do what the model asks.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// one-line message
    pub title: String,
    /// parameter to point at
    pub param: &'static str,
    /// suggested remedy
    pub help: String,
}
