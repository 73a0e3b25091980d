//! Imports models of the MIMS scripter (`.mdl`) as a [`Model`].
//!
//! An import reports everything that it changes. The format lacks units and versions, and its own tools read its
//! grammar in different ways. So each guess is a note (N201) that points into the text, and what a model cannot express
//! exactly is an error, not an approximation. Only the older dialect (`mass M x0 xDelayed`) is read. In the younger one
//! the last number is a velocity, which would be read wrongly, so that dialect is recognised and refused.
//!
//! Numbers stay as they are, as `alg` units at 44.1 kHz: in SI units the numbers of a known model would be
//! unrecognisable. Regular chains and lattices become generators again, as their authors typed them before the scripter
//! expanded them.
//!
//! ```text
//! text ─parse→ lines ─types→ typed lines ─net→ parts ─regular→ plan ─emit→ Model
//! ```

mod chain;
mod emit;
mod find_generators;
mod generator_plan;
mod graph;
mod lattice;
mod links;
mod names;
mod net;
mod parse;
mod part;
mod reader;
mod start;
mod types;

use crate::Format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Model;
use ca_model::diag::Diags;

/// Entry of MIMS in [`FORMATS`](crate::FORMATS).
pub const FORMAT: Format = Format {
    name: "MIMS",
    extension: "mdl",
    result: "strings and meshes become generators again; numbers stay as they are, in algorithmic units.",
    decode,
    import,
};

/// Decodes a MIMS file from any editor. Bytes that are not UTF-8 are Latin-1, which occurs only in comments and labels.
/// Line ends of old Macintoshes become line feeds.
///
/// ```
/// use ca_import::mims::decode;
/// assert_eq!(decode(b"# m\xfcde\r@a ground 0".to_vec()), "# m\u{fc}de\n@a ground 0");
/// ```
pub fn decode(bytes: Vec<u8>) -> String {
    let text = String::from_utf8(bytes).unwrap_or_else(|e| e.as_bytes().iter().map(|&b| char::from(b)).collect());
    if text.contains('\n') { text } else { text.replace('\r', "\n") }
}

/// Reads a MIMS model. Only the last part of `file` is used, as title and in the header comment.
///
/// The model is meant to be written, so it has neither text nor spans. The spans of the findings point into `text`.
/// With an error among the findings the model is empty and the notes are left out.
///
/// ```
/// let text = "@a mass 1. 0. 0.\n@s ground 0.\n@r springDamper @s @a 0.1 0.001\n@out1 posOutput @a\n";
/// let (model, diags) = ca_import::mims::import(text, "one.mdl");
/// assert!(diags.list.is_empty());
/// assert_eq!(model.items.len(), 4);
/// assert_eq!(model.title(), "one");
/// ```
pub fn import(text: &str, file: &str) -> (Model, Diags) {
    let mut diags = Diags::new();
    let mut model = Model::default();
    if let Some(lines) = parse::lines(text, &mut diags) {
        let typed = types::typed(&lines, &mut diags);
        let mut net = net::build(&typed, &mut diags);
        if !diags.has_errors() {
            let plan = find_generators::plan(&net.parts, &mut net.names);
            model = emit::emit(&net, &plan, file, &mut diags);
        }
    }
    if diags.has_errors() {
        diags.keep_errors(); // nothing was imported, so nothing was lost
    }
    diags.sort();
    (model, diags)
}
