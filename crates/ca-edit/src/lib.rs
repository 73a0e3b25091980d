//! Edits the text of a model: sets, clears, inserts and renames values. Comments, blanks and order stay as they are.
//!
//! [`Document`] is the text and [`Place`] a position in it. [`number`] reads and writes quantities in the unit of their
//! author, and [`equivalence`] changes the section of that name. [`Place::of`] finds a number of a model in its text,
//! and [`write_change`] writes a new value there.
//!
//! ```
//! use ca_edit::{Document, Place, number};
//! let mut text = Document::read("[CEL]\nbar = { m = \"1 g\" } # brass\n")?;
//! number::write(&mut text, &Place::keys(["CEL", "bar", "m"]), 2e-3, "kg", 8).expect("it is there");
//! assert_eq!(text.to_string(), "[CEL]\nbar = { m = \"2.0 g\" } # brass\n");
//! # Ok::<(), ca_edit::Unreadable>(())
//! ```
#![forbid(unsafe_code)]

mod change;
mod document;
pub mod equivalence;
pub mod number;
mod place;

pub use change::write_change;
pub use document::{Document, Unreadable, Value};
pub use place::{NotOne, Place};
