//! Quantity and parse error.

use alloc::string::String;
use ca_core::Dim;

/// Number with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Value in SI base units.
    pub value: f64,
    /// Dimension; [`Unit::NONE`](ca_core::Unit::NONE) if no unit is written.
    pub dim: Dim,
    /// True if a unit is written; otherwise the number is in the units of the model.
    pub has_unit: bool,
}

/// Error in the text of a quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuantityError {
    /// First byte of the wrong part.
    pub at: usize,
    /// One past its last byte; equal to `at` if something is missing.
    pub end: usize,
    /// Description of the error.
    pub message: String,
    /// Suggested text for this part.
    pub hint: Option<String>,
}

impl core::fmt::Display for QuantityError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.message)?;
        self.hint.as_ref().map_or(Ok(()), |h| write!(f, "; did you mean `{h}`?"))
    }
}
impl core::error::Error for QuantityError {}
