//! Documents say what is so: pages, the README, codes, the schema of an editor, and the words of all of them.

pub mod docs;
mod explain;
mod readme;
mod schema;
mod words;
