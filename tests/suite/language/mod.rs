//! The language: reader and writer, names, quantities, selectors, parts, diagnostics.

mod bundled_parts;
mod diagnostics;
mod large;
mod part_limits;
mod parts;
mod quantity;
mod reader;
mod scaled;
mod select;
mod set;
mod toml;
mod writer;
