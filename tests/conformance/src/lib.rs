//! Conformance of laws: every kind of the catalog satisfies its record.
//!
//! No test names a kind, so a new law is tested as soon as it is listed. [`felt`] is an unlisted law, added as another
//! crate would add it. `cargo test -p ca-conformance` builds only the language, the compiler and the run-time, so it is
//! quick after a change of a law.

pub mod felt;
pub mod models;
pub mod play;
pub mod random_parameters;

#[cfg(test)]
mod axes;
#[cfg(test)]
mod felt_played;
#[cfg(test)]
mod forces;
#[cfg(test)]
mod forms;
#[cfg(test)]
mod records;
#[cfg(test)]
mod time;
