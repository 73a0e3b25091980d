//! The whole suite in one binary, one file per theme.

mod acoustics;
mod border;
mod chance;
mod compile_fuzz;
mod conformance;
mod diagnostics;
mod files;
mod generate_space;
mod guard;
mod lpr;
mod mims;
mod models;
mod oracle;
mod outputs;
mod play;
mod published;
mod quantity;
mod reader;
mod references;
mod scheme;
mod select;
mod set;
mod sets;
mod space;
mod stable;
mod writer;
