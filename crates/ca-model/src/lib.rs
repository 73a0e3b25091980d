//! The language of models: kinds, names, spans, [quantities](quantity), [diagnostics](diag), [generators](generate).
//!
//! A [`Model`] is what an author writes, before any number is converted. Text, the Python builder and importers all
//! produce this type. Values stay *as written* (`"20 g"` stays `"20 g"`), and each has the [`Span`] it came from, so
//! that any later finding can point at it. Only the compiler, `ca-compile`, gives meaning (units, references, ranges),
//! because two interpreters would sooner or later differ.
//!
//! `read` reads a text, and [`part`] has the parts that a model takes from other files. `ca-compile` makes a scene of a
//! [`Model`], and `cordis-anima` plays it. A kind that expands to many modules is a generator, see [`generate`].

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
pub mod printable;
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

/// Returns the kinds of the run-time and the generators. Kinds of other crates join them by [`Catalog::with`].
pub fn catalog() -> Catalog {
    Catalog::core().with(generate::KINDS)
}
