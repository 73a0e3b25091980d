//! Tests of documents: the README, the pages of `docs/`, codes, the JSON Schema, and terminology.

mod commands;
mod completions;
pub mod docs;
mod explain;
mod readme;
mod schema;
mod words;
