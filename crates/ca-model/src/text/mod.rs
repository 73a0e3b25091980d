//! Converts the text of one file to a model, with its parts as written. It does not open files.

mod blocks;
pub(crate) mod entry;
pub(crate) mod file;
mod members;
mod newer;
pub(crate) mod reader;
mod syntax;
