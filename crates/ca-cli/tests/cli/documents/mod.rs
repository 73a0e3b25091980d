//! Documents: the README and the pages of `docs/`, codes, the JSON Schema, words of the field.

mod completions;
pub mod docs;
mod explain;
mod readme;
mod schema;
mod words;
