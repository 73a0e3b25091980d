//! What a model says: text in, text out, names, quantities, parts, and what is found in it.

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
mod writer;
