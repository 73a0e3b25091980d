//! The whole suite in one binary, one file per theme.

mod diagnostics;
mod files;
mod mims;
mod quantity;
mod reader;
mod select;
mod writer;
