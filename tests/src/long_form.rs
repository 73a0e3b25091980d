//! What is left to the long form of the tests, `tests/run --long`, for the time it takes.
//!
//! Decides that the core suite says so each time, in the list of what it skipped: nobody takes a part for the whole.

use crate::skipped::skipped;

/// True in the long form, where `CA_LONG` is set. Elsewhere notes that the calling test leaves `what` to it.
#[track_caller]
pub fn long_form(what: &str) -> bool {
    let long = std::env::var_os("CA_LONG").is_some();
    if !long {
        skipped("time", &format!("left to tests/run --long: {what}"));
    }
    long
}
