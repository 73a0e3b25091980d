//! The language: reader and writer, names, quantities, selectors, parts, diagnostics.

mod diagnostics;
mod large;
mod parts;
mod parts_apart;
mod parts_shipped;
mod quantity;
mod reader;
mod scaled;
mod select;
mod set;
mod toml;
mod writer;
