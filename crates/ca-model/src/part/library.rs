//! The bundled parts, which any model may use.
//!
//! A part that the model does not have is looked up here, so a bow is `{ part = "bow" }`. Its text becomes a file of
//! the model, `ca:bow.ca.toml`. Findings point into it, and a take that contains it replays with it, whatever a later
//! version of the program bundles. The colon distinguishes it from files on disk.

use crate::model::Part;
use crate::text::file::one_file;
use alloc::format;
use alloc::string::String;
use ca_core::Catalog;

/// Start of the file name of a bundled part.
const PREFIX: &str = "ca:";

macro_rules! parts {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../parts/", $name, ".ca.toml")))),*]
    };
}

/// Names, in order, and texts. Each is a file of `parts/` that contains a part of the same name.
pub static LIBRARY: &[(&str, &str)] = parts!["bow", "mallet", "piano_action", "piano_key", "piano_strings", "plectrum"];

pub(super) fn file(name: &str) -> Option<(String, &'static str)> {
    let (_, text) = LIBRARY.iter().find(|p| p.0 == name)?;
    Some((format!("{PREFIX}{name}.ca.toml"), text))
}

/// Returns true for the file name of a bundled part, which is not a file on disk.
pub fn is_shipped(file: &str) -> bool {
    file.starts_with(PREFIX)
}

/// Returns a bundled part as written and the comment above it; `None` for an unknown name.
pub fn shipped(name: &str, catalog: &Catalog) -> Option<(Part, String)> {
    let (file, text) = file(name)?;
    let model = one_file(text, &file, catalog).0;
    let header = model.header;
    model.parts.into_iter().find(|p| p.name == name).map(|p| (p, header))
}
