//! Edits the text of a model. Comments, blanks and order stay as they are.
//!
//! [`Operation`] has what a bench or an editor does: add, join, set, rename with all references, delete with
//! dependents, duplicate, group to a part, move, map keys, set the scale. Each returns an [`Edited`] text or a
//! [`Refusal`]. [`History`] has undo and redo, and [`diagnostics`](diagnostics::diagnostics) the findings with byte
//! ranges. Operations change names in this file only, not in the files that it takes parts from.
//!
//! Below them, [`Document`] is the text and [`Place`] a position in it. [`number`] reads and writes quantities in the
//! unit of their author, and [`equivalence`] changes the section of that name. [`Place::of`] finds a number of a model in
//! its text, and [`write_change`] writes a new value there.
//!
//! ```
//! use ca_edit::{Document, Place, number};
//! let mut text = Document::read("[CEL]\nbar = { m = \"1 g\" } # brass\n")?;
//! number::write(&mut text, &Place::keys(["CEL", "bar", "m"]), 2e-3, "kg", 8).expect("it is there");
//! assert_eq!(text.to_string(), "[CEL]\nbar = { m = \"2.0 g\" } # brass\n");
//! # Ok::<(), ca_edit::Unreadable>(())
//! ```
#![forbid(unsafe_code)]

mod add;
mod change;
mod delete;
pub mod diagnostics;
mod document;
mod duplicate;
pub mod equivalence;
mod group;
mod history;
mod layout;
mod map;
pub mod number;
mod operation;
mod paths;
mod place;
mod references;
mod refusal;
mod rename;
mod shift;
mod symbols;
mod text_edit;
mod tree;
mod value;

pub use change::write_change;
pub use diagnostics::{Diagnostic, diagnostics};
pub use document::{Document, Unreadable, Value};
pub use history::History;
pub use map::MidiSource;
pub use operation::Operation;
pub use place::{NotOne, Place};
pub use refusal::Refusal;
pub use text_edit::{Edited, TextEdit};
