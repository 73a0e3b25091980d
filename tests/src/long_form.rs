//! Leaves slow tests to the long form, `tests/run --long`.
//!
//! The core suite lists each of them as skipped, so that a partial run is never taken for a full one.

use crate::skipped::skipped;

/// Returns true in the long form, with `CA_LONG` set. Otherwise lists `what` of the calling test as skipped.
#[track_caller]
pub fn long_form(what: &str) -> bool {
    let long = std::env::var_os("CA_LONG").is_some();
    if !long {
        skipped("time", &format!("left to tests/run --long: {what}"));
    }
    long
}
