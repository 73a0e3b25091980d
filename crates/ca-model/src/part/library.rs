//! Library: the parts that come with the program, which any model may use.
//!
//! Decides that a part which a model names and does not have is looked for here, so that a bow is `{ part = "bow" }`, and that
//! its text is then one of the files of the model, called `ca:bow.ca.toml`: findings point into it, and a take that holds it is
//! replayed with it, whatever a later version of the program ships. The colon keeps the names of files on disk apart.

use crate::model::Part;
use crate::text::file::one_file;
use alloc::format;
use alloc::string::String;
use ca_core::Catalog;

/// What the file of a shipped part begins with.
const PREFIX: &str = "ca:";

macro_rules! parts {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../parts/", $name, ".ca.toml")))),*]
    };
}

/// Their names, in order, and texts: each is a file of `parts/` that holds a part of its own name.
pub static LIBRARY: &[(&str, &str)] = parts!["bow", "mallet", "piano_action", "piano_key", "piano_strings", "plectrum"];

/// The file that the text of a shipped part is called, and that text.
pub(super) fn file(name: &str) -> Option<(String, &'static str)> {
    let (_, text) = LIBRARY.iter().find(|p| p.0 == name)?;
    Some((format!("{PREFIX}{name}.ca.toml"), text))
}

/// Whether a file that a model was read from came with the program, so that there is none on disk.
pub fn is_shipped(file: &str) -> bool {
    file.starts_with(PREFIX)
}

/// A shipped part as it is written, and what its author says of it above it; nothing where there is none of that name.
pub fn shipped(name: &str, catalog: &Catalog) -> Option<(Part, String)> {
    let (file, text) = file(name)?;
    let model = one_file(text, &file, catalog).0;
    let header = model.header;
    model.parts.into_iter().find(|p| p.name == name).map(|p| (p, header))
}
