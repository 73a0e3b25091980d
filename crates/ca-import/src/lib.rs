//! Models in the formats of others.
//!
//! Decides on a crate of its own: nobody who reads a model of ours pays for the grammars of other programs, and each
//! format is a folder that knows the language ([`ca_model`]) and nothing of the compiler. [`FORMATS`] lists them: to add one,
//! write a folder and add a line to the list.
//!
//! What is not here: models of ours, which `ca_model::read` reads, and files beside a model (`ca-io`). A program opens a model of any
//! format by `cordis_anima::Loaded`.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod mims;

use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Model;
use ca_model::diag::Diags;

/// A file format of another program.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// the name in messages
    pub name: &'static str,
    /// extension of its files, without the dot, in lower case
    pub extension: &'static str,
    /// how `ca import --help` describes the model that comes out
    pub result: &'static str,
    /// the text of a file
    pub decode: fn(Vec<u8>) -> String,
    /// a model from its text, and the findings; the second argument is the name of its file in reports. With errors, the
    /// model is empty.
    pub import: fn(&str, &str) -> (Model, Diags),
}

/// All formats. A file without a known extension is imported as the first of them.
pub const FORMATS: &[Format] = &[mims::FORMAT];

/// The format of a file, by its extension; none for our own.
///
/// ```
/// assert_eq!(ca_import::of("old/String.MDL").map(|f| f.name), Some("MIMS"));
/// assert!(ca_import::of("string.ca.toml").is_none());
/// ```
pub fn of(file: &str) -> Option<&'static Format> {
    let (_, extension) = file.rsplit_once('.')?;
    FORMATS.iter().find(|f| extension.eq_ignore_ascii_case(f.extension))
}

/// The format in which `ca import` reads a file: by its extension, or else the first.
pub fn assumed(file: &str) -> &'static Format {
    of(file).unwrap_or(&FORMATS[0])
}
