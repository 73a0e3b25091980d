//! Each law by itself and against solutions from outside.

pub mod conformance;
mod equivalence;
mod lpr;
mod pluck;
pub mod references;
