//! Arguments of several commands: options, forms of their values, and their completion by a shell. The other arguments stand with
//! their commands.

pub mod common;
pub mod completions;

pub use common::{Playing, Source};
