//! Converts the text of one file to a model, with its parts as written. It does not open files.

mod blocks;
pub(crate) mod entry;
pub(crate) mod file;
mod members;
pub(crate) mod reader;
mod syntax;
mod toml_1_1;
