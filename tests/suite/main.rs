//! The whole suite in one binary, one file per theme.

mod diagnostics;
mod files;
mod mims;
mod play;
mod quantity;
mod reader;
mod scheme;
mod select;
mod writer;
