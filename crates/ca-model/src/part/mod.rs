//! Parts: a piece of an instrument that is written once, with parameters, and used many times.
//!
//! Decides that a part is read as a small model and that its instances are modules like all others, called `key[3].hammer`:
//! nobody behind the reader knows of parts, so whatever works for a module works for one of an instance. A number that
//! stands for a parameter of the part becomes a `[param]` of the model, called `key[3].f`, so that units, limits, live changes
//! and findings are those of any other; anything else (a module, a word, a file) is put in its place. A name is looked
//! for in the part first, then at the root of the model. Against templates of text: a finding could not point into them.

#[cfg(feature = "parse")]
mod beside;
#[cfg(feature = "parse")]
mod expand;
#[cfg(feature = "parse")]
mod expander;
#[cfg(feature = "parse")]
mod fan;
pub mod files;
#[cfg(feature = "parse")]
mod find;
#[cfg(feature = "parse")]
mod instance;
#[cfg_attr(not(feature = "parse"), allow(dead_code))]
mod instances;
#[cfg(feature = "parse")]
pub mod library;
#[cfg(feature = "parse")]
mod read;
#[cfg(feature = "parse")]
mod scope;
#[cfg(feature = "parse")]
mod shift;
#[cfg(feature = "parse")]
mod size;

#[cfg(feature = "parse")]
use super::diag::Diags;
#[cfg(feature = "parse")]
use super::model::Model;
pub use super::model::{Part, Use};
#[cfg(feature = "parse")]
use ca_core::Catalog;
#[cfg(feature = "parse")]
pub(super) use expand::expand;
#[cfg(feature = "parse")]
pub use expand::{add, add_shipped};
pub use instances::instances;

/// Makes lists of names of many instances, `key[*].hammer`, in a model that a program built; where there are no such
/// instances it says so.
#[cfg(feature = "parse")]
pub fn lists(model: &mut Model, catalog: &Catalog) -> Diags {
    let mut diags = Diags::new();
    fan::fan(model, catalog, &mut diags);
    diags
}
