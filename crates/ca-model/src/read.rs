//! Reads a model: its own file, and the parts it takes from others.
//!
//! Parts are put in while a model is read, so later stages do not see them. A file is read in the same way whether it
//! is a model or contains parts; that step is in `text` and opens no files.

use super::diag::Diags;
use super::model::Model;
use super::part;
pub use super::sections::{GROUP, META, RATES, SECTIONS};
use super::text::file::one_file;
use alloc::format;
use alloc::string::String;
use ca_core::Catalog;
use ca_core::internal::kind::cloud::Unread;

/// Reads the text of a model. `file` is its name in reports.
///
/// The model contains all that could be understood, even beside errors. Modules of an unknown kind keep their code as
/// written, so that links to them still resolve. A duplicate, or a module without a valid name, is left out, and its
/// name is added to [`Model::lost`].
///
/// ```
/// use ca_core::Catalog;
/// use ca_model::read::read;
/// let (model, diags) = read("[MAS]\nbob = { m = '20 g', mm = 3 }", "bob.ca.toml", &ca_model::catalog());
/// assert_eq!(model.items[0].name, "bob");
/// assert_eq!(diags.list[0].title, "`bob`: unknown parameter `mm`");
/// ```
pub fn read(text: &str, file: &str, catalog: &Catalog) -> (Model, Diags) {
    read_with(text, file, catalog, &mut |name| {
        let help = "save the model in the same folder and read it from there; a program must pass the text of the file";
        Err(Unread { what: format!("the file `{name}` is not available"), help: help.into() })
    })
}

/// Reads a model as [`read`] does. `open` returns the text of a file that parts are taken from, by its path from the
/// folder of the model, or the reason why it cannot.
pub fn read_with(
    text: &str,
    file: &str,
    catalog: &Catalog,
    open: &mut dyn FnMut(&str) -> Result<String, Unread>,
) -> (Model, Diags) {
    let (mut model, mut diags) = one_file(text, file, catalog);
    part::expand(&mut model, &mut diags, catalog, open);
    diags.sort();
    (model, diags)
}

/// Reads a model without its parts put in: what the file itself contains. An editor finds the names of the file by
/// their places; [`Model::parts`] and [`Model::uses`] have the parts.
pub fn written(text: &str, file: &str, catalog: &Catalog) -> (Model, Diags) {
    one_file(text, file, catalog)
}
