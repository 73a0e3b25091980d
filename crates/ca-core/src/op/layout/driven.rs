//! Layout of what a port drives: the port, and a table of the coefficients that follow from it.
//!
//! Decides that the record stands among the arrays of the layout and not beside the pass that reads it
//! ([`drive`](crate::op::driven::drive)): the pass reads the layout, and the layout is whole without it.

use crate::numeric::Real;
use alloc::vec::Vec;

/// A parameter that a port drives.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bytes", derive(serde::Serialize, serde::Deserialize), serde(bound = "R: crate::numeric::Stored"))]
pub struct Driven<R: Real = f64> {
    /// the port: a place in [`State::input`](crate::state::State::input)
    pub input: u32,
    /// where the port is at the smallest and at the largest value of the parameter \[m\] or \[N\]
    pub span: [f64; 2],
    /// rows of the table, at least two
    pub rows: usize,
    /// the coefficients that it reaches: indices into [`LivePlan::coefs`](crate::live::LivePlan::coefs) (places)
    pub places: Vec<u32>,
    /// their values at equal steps of the parameter (rows x places)
    pub table: Vec<R>,
}
