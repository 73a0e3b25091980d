//! Models in the formats of others.
//!
//! Decides on a crate of its own: nobody who reads a model of ours pays for the grammars of other programs, and each
//! format is a folder that knows the language ([`ca_model`]) and nothing of the compiler. [`reads`] and [`import`] are where all
//! others meet a format; to add one, a folder and a line in each.
//!
//! What is not here: models of ours, which `ca_model::read` reads, and files beside a model (`ca-io`). A program opens a model of any
//! format by `cordis_anima::Loaded`.
#![no_std]
#![forbid(unsafe_code)]

extern crate alloc;

pub mod mims;

use ca_model::Model;
use ca_model::diag::Diags;

/// True where the extension of a file is that of a format of others.
pub fn reads(file: &str) -> bool {
    file.rsplit_once('.').is_some_and(|(_, extension)| extension.eq_ignore_ascii_case("mdl"))
}

/// A model from its text, and what was found; `file` is its name in reports. With errors, the model is empty.
pub fn import(text: &str, file: &str) -> (Model, Diags) {
    mims::import(text, file)
}
