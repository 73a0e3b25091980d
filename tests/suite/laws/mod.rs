//! Laws of interaction: closed forms and LPR. `tests/conformance` checks all kind records.

mod lpr;
mod pluck;
pub mod references;
