//! The whole suite in one binary, one file per theme.

mod mims;
mod files;
mod diagnostics;
mod quantity;
mod reader;
mod select;
mod writer;
