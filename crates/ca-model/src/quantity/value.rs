//! A number with its dimension, and what is wrong in a text that should be one.

use alloc::string::String;
use ca_core::Dim;

/// A number with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// in SI base units
    pub value: f64,
    /// its dimension; without a unit, the dimension of [`Unit::NONE`](ca_core::Unit::NONE)
    pub dim: Dim,
    /// whether a unit is written; without one the number is in the model's units
    pub has_unit: bool,
}

/// What is wrong in the text of a quantity, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuantityError {
    /// first byte of the part that is wrong
    pub at: usize,
    /// one past its last byte; equal to `at` where something is missing
    pub end: usize,
    /// what is wrong
    pub message: String,
    /// what could be written there instead
    pub hint: Option<String>,
}

impl core::fmt::Display for QuantityError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.message)?;
        self.hint.as_ref().map_or(Ok(()), |h| write!(f, "; did you mean `{h}`?"))
    }
}
impl core::error::Error for QuantityError {}
