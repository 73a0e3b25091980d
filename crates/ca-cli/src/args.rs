//! Arguments shared by several commands: options, value parsers, and shell completion. Other arguments are beside their
//! commands.

pub mod common;
pub mod completions;

pub use common::{Playing, Source};
