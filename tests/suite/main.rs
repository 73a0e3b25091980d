//! The whole suite in one binary, one file per theme.

mod acoustics;
mod diagnostics;
mod files;
mod mims;
mod models;
mod quantity;
mod reader;
mod select;
mod writer;
