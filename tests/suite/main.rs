//! The whole suite in one binary, one file per theme.

mod compile_fuzz;
mod diagnostics;
mod files;
mod mims;
mod play;
mod quantity;
mod reader;
mod scheme;
mod select;
mod set;
mod writer;
