//! What several commands take: options and forms of their values, and how a shell completes them. The other arguments stand with
//! their commands.

pub mod common;
pub mod completions;

pub use common::{Playing, Source};
