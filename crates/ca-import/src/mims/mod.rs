//! Models of the MIMS scripter (`.mdl`), read into a [`Model`].
//!
//! Decides that an import says everything it changes. The format has no units, no versions and a grammar that its own
//! tools read differently, so each guess is a note (N201) that points into the text, and what cannot be said exactly
//! is an error, not an approximation. Only the older dialect (`mass M x0 xDelayed`) is read; in the younger one the
//! last number is a velocity, so reading it would be wrong without a sign of it: it is recognised and refused.
//! Numbers are taken over as they are, as `alg` units at 44.1 kHz; converting them to SI would make every figure of a
//! known model unrecognisable. Regular chains and lattices become generators again, which is what their authors typed
//! before the scripter expanded them.
//!
//! ```text
//! text ─parse→ lines ─types→ typed lines ─net→ parts ─regular→ plan ─emit→ Model
//! ```

mod chain;
mod emit;
mod first;
mod graph;
mod lattice;
mod links;
mod names;
mod net;
mod parse;
mod part;
mod plan;
mod reader;
mod regular;
mod types;

use crate::Format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Model;
use ca_model::diag::Diags;

/// MIMS, for [`FORMATS`](crate::FORMATS).
pub const FORMAT: Format = Format {
    name: "MIMS",
    extension: "mdl",
    result: "strings and meshes become generators again; numbers stay as they are, in algorithmic units.",
    decode,
    import,
};

/// The text of a MIMS file, whatever wrote it: bytes that are not UTF-8 are Latin-1, which only comments and labels can
/// hold, and lines that end as on old Macintoshes end as everywhere else.
///
/// ```
/// use ca_import::mims::decode;
/// assert_eq!(decode(b"# m\xfcde\r@a ground 0".to_vec()), "# m\u{fc}de\n@a ground 0");
/// ```
pub fn decode(bytes: Vec<u8>) -> String {
    let text = String::from_utf8(bytes).unwrap_or_else(|e| e.as_bytes().iter().map(|&b| char::from(b)).collect());
    if text.contains('\n') { text } else { text.replace('\r', "\n") }
}

/// Reads a MIMS model. `file` is its name, of which only the last part is kept, as title and in the header comment.
///
/// The model carries no text and no spans: it is meant to be written. The spans of the findings point into `text`.
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
            let plan = regular::plan(&net.parts, &mut net.names);
            model = emit::emit(&net, &plan, file, &mut diags);
        }
    }
    if diags.has_errors() {
        diags.keep_errors(); // nothing was imported, so nothing was lost
    }
    diags.sort();
    (model, diags)
}
