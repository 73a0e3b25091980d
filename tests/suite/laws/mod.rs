//! Laws of interaction: conformance of each, closed forms, LPR.

pub mod conformance;
mod lpr;
mod pluck;
pub mod references;
