//! The generated pages: `docs/protocol.md` and the JSDoc types of the page.

use super::VERSION;
use super::define::Kind;
use super::message::{Bound, Choices, DeviceState, Message, Param, Picked, PortInfo, Preset};
use super::request::Request;
use std::fmt::Write as _;

/// The records inside messages, in the order of the pages.
fn records() -> [Kind; 7] {
    [
        Param::kind(),
        Preset::kind(),
        PortInfo::kind(),
        DeviceState::kind(),
        Bound::kind(),
        Choices::kind(),
        Picked::kind(),
    ]
}

/// `docs/protocol.md`.
pub fn page() -> String {
    let mut text = format!(
        "# Messages between the page and the program\n\n\
         After this page you can write another page for `ca play`, or a program that sends it the same messages.\n\n\
         Made by `UPDATE=1 cargo test -p ca-session --test protocol` from the types in `crates/ca-session/src/protocol`: do \
         not edit.\n\n\
         Version {VERSION}. Text is JSON, an object with a `type`. A page sends requests over the socket `ws` beside its \
         own address ([play.md](play.md)); each request that has an `id` is answered by a `reply` with the \
         same `id`, and each one that is refused, too.\n"
    );
    section(&mut text, "From the page", "type", &Request::kinds());
    section(&mut text, "To the page", "type", &Message::kinds());
    section(&mut text, "Records in these messages", "record", &records());
    text += "\n## Bytes to the page\n\n\
             Little-endian. Pictures are sent at most 60 times a second, sound only to a page that asked for it.\n\n\
             | bytes | picture | sound |\n|---|---|---|\n\
             | 0 to 3, u32 | 1 | 2 |\n\
             | 4 to 7, u32 | `generation` of the scene | channels |\n\
             | 8 to 15, f64 | tick | tick of the first sample |\n\
             | from 16 on, f32 | displacement \\[m\\] of each drawn mass: one number on a line, three in space | samples, \
             interleaved |\n";
    text
}

/// A table of all kinds, one row for each field.
fn section(text: &mut String, title: &str, first: &str, kinds: &[Kind]) {
    let _ = write!(text, "\n## {title}\n\n| {first} | field | JavaScript | meaning |\n|---|---|---|---|\n");
    for kind in kinds {
        let _ = writeln!(text, "| `{}` | | | {} |", kind.name, kind.doc);
        for (name, js, doc) in fields(kind) {
            let _ = writeln!(text, "| | `{name}` | `{}` | {doc} |", js.replace('|', "\\|"));
        }
    }
}

/// The fields of a kind as they stand in the object: a reply has the fields of `picked` itself.
fn fields(kind: &Kind) -> Vec<(String, String, String)> {
    let mut all = Vec::new();
    for (name, js, doc) in &kind.fields {
        if *name == "picked" {
            let optional = |(name, js, doc): &(&str, String, String)| {
                (format!("{name}?"), js.clone(), format!("of `pick`: {doc}"))
            };
            all.extend(Picked::kind().fields.iter().map(optional));
        } else {
            all.push(((*name).into(), js.clone(), doc.clone()));
        }
    }
    all
}

/// `crates/ca-play/page/protocol.js`: types for editors and for `tsc`, without code.
pub fn jsdoc() -> String {
    let mut text = format!(
        "// The messages between this page and the program, version {VERSION}, as types in JSDoc. Made by\n\
         // `UPDATE=1 cargo test -p ca-session --test protocol` from crates/ca-session/src/protocol: do not edit. The page does not\n\
         // load this file.\n\nexport {{}};\n"
    );
    for kind in records() {
        define(&mut text, &kind, kind.name, None);
    }
    for (what, kinds) in [("Request", Request::kinds()), ("Message", Message::kinds())] {
        let names: Vec<String> = kinds.iter().map(|k| format!("{}{what}", capital(k.name))).collect();
        for (kind, name) in kinds.iter().zip(&names) {
            define(&mut text, kind, name, Some(kind.name));
        }
        let _ = write!(text, "\n/** @typedef {{{}}} {what} */\n", names.join("|"));
    }
    text
}

/// One type.
fn define(text: &mut String, kind: &Kind, name: &str, wire: Option<&str>) {
    let _ = write!(text, "\n/**\n * {}\n * @typedef {{object}} {name}\n", plain(&kind.doc));
    if let Some(wire) = wire {
        let _ = writeln!(text, " * @property {{\"{wire}\"}} type");
    }
    for (name, js, doc) in fields(kind) {
        let shown = name.strip_suffix('?').map_or(name.clone(), |n| format!("[{n}]"));
        let _ = writeln!(text, " * @property {{{js}}} {shown} {}", plain(&doc));
    }
    text.push_str(" */\n");
}

/// Text of Markdown as a comment has it.
fn plain(doc: &str) -> String {
    doc.replace("\\[", "[").replace("\\]", "]")
}

fn capital(name: &str) -> String {
    let mut all = name.chars();
    all.next().map_or_else(String::new, |c| c.to_uppercase().chain(all).collect())
}
