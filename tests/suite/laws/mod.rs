//! Laws of interaction: closed forms, LPR. `tests/conformance` has the promises of all records.

mod lpr;
mod pluck;
pub mod references;
