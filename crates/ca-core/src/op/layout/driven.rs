//! Layout of a parameter driven by a port: the port, and a table of the coefficients that follow from it.
//!
//! The record is part of the layout, not of its pass [`drive`](crate::op::driven::drive), which reads the layout.

use crate::numeric::Real;
use alloc::vec::Vec;

/// A parameter driven by a port.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Driven<R: Real = f64> {
    /// index of the port in [`State::input`](crate::state::State::input)
    pub input: u32,
    /// port values for the smallest and the largest value of the parameter \[m\] or \[N\]
    pub span: [f64; 2],
    /// number of rows of the table, at least two
    pub rows: usize,
    /// coefficients to set: indices into [`LiveTable::coefs`](crate::live::LiveTable::coefs) (places)
    pub places: Vec<u32>,
    /// their values at equal steps of the parameter (rows x places)
    pub table: Vec<R>,
}
