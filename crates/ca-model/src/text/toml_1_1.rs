//! Finds the first place in a file that requires TOML 1.1.
//!
//! It gets a note, not an error: `ca` reads such a file, but Python's `tomllib` and most editors do not.

use crate::diag::Diag;
use crate::model::Span;
use alloc::format;

/// Construct that TOML 1.0 refuses, by its offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Newer {
    /// Table `{ … }` that begins here and continues on other lines.
    Lines(usize),
    /// Comma before a `}`.
    Comma(usize),
    /// Escape sequence `\\e` or `\\x`.
    Escape(usize),
}

impl Newer {
    /// Finds the first of `\\e` and `\\x` in the string from `start` to `end`.
    pub(super) fn escape(text: &str, start: usize, end: usize) -> Option<Newer> {
        let bytes = text.as_bytes();
        let mut at = start + 1;
        while at < end {
            match (bytes.get(at), bytes.get(at + 1)) {
                (Some(b'\\'), Some(b'e' | b'x')) => return Some(Newer::Escape(at)),
                (Some(b'\\'), _) => at += 2,
                _ => at += 1,
            }
        }
        None
    }

    pub(super) fn note(self, text: &str) -> Diag {
        let span = |at, n| Span { start: at, end: at + n };
        let note = |title: &str, span, label: &str| Diag::note("N205", format!("TOML 1.1: {title}")).at(span, label);
        let others = "Python's `tomllib` and other readers of TOML 1.0 refuse the file";
        match self {
            Newer::Lines(at) => note("a table in braces spans several lines", span(at, 1), "begins here")
                .help(format!("{others}: write it on one line, or one entry per line as `key.f = …`")),
            Newer::Comma(at) => note("a comma before `}`", span(at, 1), "no entry follows")
                .help(format!("{others}: remove it"))
                .fix(span(at, 1), ""),
            Newer::Escape(at) => {
                let code = if text.as_bytes().get(at + 1) == Some(&b'e') { "u001b" } else { "u00" };
                let help = format!("{others}: write `\\{code}` instead");
                note("an escape sequence in a string", span(at, 2), "since TOML 1.1")
                    .help(help)
                    .fix(span(at, 2), format!("\\{code}"))
            }
        }
    }
}
