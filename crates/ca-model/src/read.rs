//! Reading a model: its own file, and the parts it takes from others.
//!
//! Decides that parts are put in as a model is read, so that nobody behind the reader knows of them, and that a file is read
//! alike whether a model or a part stands in it: that is one step below, and opens nothing.

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
/// The model holds all that could be understood, even beside errors. Modules of an unknown kind are kept under the
/// code as written, so that links to them still resolve; what is written twice or has no valid name is left out, the
/// name kept in [`Model::lost`].
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
        let help = "save the model in a file beside it; a program that reads hands over what files hold";
        Err(Unread { what: format!("`{name}` is not at hand"), help: help.into() })
    })
}

/// As [`read`], where `open` gives the text of the files that parts are taken from, by their paths from the folder of the
/// model, or says why there is none.
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
