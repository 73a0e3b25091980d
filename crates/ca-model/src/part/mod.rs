//! Parts: pieces of an instrument that are written once, with parameters, and used many times.
//!
//! A part is read as a small model, and its instances become ordinary modules such as `key[3].hammer`. Later stages do
//! not see parts, so all that works for a module works for one in an instance.
//!
//! A parameter of a part that is a number becomes a `[param]` of the model, `key[3].f`, with the usual units, limits,
//! live changes and findings. Other parameters (a module, a word, a file) are substituted. A name is looked up in the
//! part first, then at the root of the model. Text templates were rejected because a finding could not point into them.

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
mod ignored_sections;
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

/// Expands names of many instances, `key[*].hammer`, to lists in a model that a program built. Reports missing
/// instances.
#[cfg(feature = "parse")]
pub fn lists(model: &mut Model, catalog: &Catalog) -> Diags {
    let mut diags = Diags::new();
    fan::fan(model, catalog, &mut diags);
    diags
}
