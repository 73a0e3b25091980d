//! The language of models: what an author writes, before any number is converted, and how it is read, written, described
//! and reported. Kinds, names, parameters, spans, [quantities](quantity), [diagnostics](diag), [generators](generate).
//!
//! Decides that text, the Python builder and importers all produce this one type, that it keeps values *as written*
//! (`"20 g"` stays `"20 g"`), and that every piece carries the [`Span`] it came from, so that any later finding can
//! point at it. Meaning (units, references, ranges) is given by the compiler, a crate above this one: two readers of
//! meaning would disagree one day.
//!
//! To read a text begin with `read`; what a model takes from other files is in [`part`].
//!
//! What is not here: a scene. `ca-compile` makes one of a [`Model`]; a program that plays models adds `cordis-anima`. To add a kind of
//! module that is built of others, begin with [`generate`].

#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;
#[cfg(feature = "parse")]
extern crate std;

pub mod diag;
#[cfg(feature = "parse")]
pub mod explain;
pub mod generate;
mod model;
pub mod names;
#[cfg(feature = "parse")]
pub mod page;
pub mod part;
pub mod plain;
pub mod quantity;
#[cfg(feature = "parse")]
pub mod read;
#[cfg(feature = "parse")]
pub mod render;
#[cfg(feature = "parse")]
pub mod schema;
pub mod sections;
pub mod select;
pub mod suggest;
#[cfg(feature = "parse")]
mod text;
pub mod write;

use ca_core::Catalog;
pub use model::{Entry, Group, Item, LARGEST, Model, Span, Value, in_list};

/// The kinds a model is written with: those of the run-time, and the generators. Kinds of other crates join them by
/// [`Catalog::with`].
pub fn catalog() -> Catalog {
    Catalog::core().with(generate::KINDS)
}
