//! Imports models in the formats of other programs.
//!
//! The grammars of other programs are in a separate crate so that only importers build them. Each format is a folder
//! that depends on the language ([`ca_model`]) but not on the compiler, and a line in [`FORMATS`].
//!
//! `ca_model::read` reads model files, `ca-io` files beside a model, and `cordis_anima::Loaded` a model of any format.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod mims;

use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Model;
use ca_model::diag::Diags;

/// File format of another program.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Name in messages.
    pub name: &'static str,
    /// Extension of the files, without the dot, in lower case.
    pub extension: &'static str,
    /// Description of the resulting model in `ca import --help`.
    pub result: &'static str,
    /// Decodes the bytes of a file.
    pub decode: fn(Vec<u8>) -> String,
    /// Reads a model from its text and its file name for reports; with errors among the findings, the model is empty.
    pub import: fn(&str, &str) -> (Model, Diags),
}

/// All formats. A file without a known extension is imported as the first of them.
pub const FORMATS: &[Format] = &[mims::FORMAT];

/// Returns the format for a file extension; `None` for model files of this project.
///
/// ```
/// assert_eq!(ca_import::of("old/String.MDL").map(|f| f.name), Some("MIMS"));
/// assert!(ca_import::of("string.ca.toml").is_none());
/// ```
pub fn of(file: &str) -> Option<&'static Format> {
    let (_, extension) = file.rsplit_once('.')?;
    FORMATS.iter().find(|f| extension.eq_ignore_ascii_case(f.extension))
}

/// Returns the format in which `ca import` reads a file: by its extension, otherwise the first.
pub fn assumed(file: &str) -> &'static Format {
    of(file).unwrap_or(&FORMATS[0])
}
