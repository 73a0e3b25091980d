//! Page of a diagnostic: the meaning of its code, with example models and the report of each.
//!
//! The pages are files of this crate (`diagnostics/*.md`) and compiled in, so a program explains the codes of its
//! version without a network or a folder. A file covers one subject and has a section `## E013 unknown name` for each
//! code; the page of a code is all its sections. A test checks that every code has one and that the reports are
//! current.

use super::diag::{CODES, Severity};
use alloc::string::String;
use alloc::vec::Vec;

/// Files in the order in which an author meets them.
const FILES: [&str; 8] = [
    include_str!("../diagnostics/reading.md"),
    include_str!("../diagnostics/values.md"),
    include_str!("../diagnostics/names.md"),
    include_str!("../diagnostics/rates.md"),
    include_str!("../diagnostics/stability.md"),
    include_str!("../diagnostics/equivalence.md"),
    include_str!("../diagnostics/waveguide.md"),
    include_str!("../diagnostics/mims.md"),
];

/// Page of one code.
#[derive(Clone, Debug)]
pub struct Page {
    /// Code, an entry of [`CODES`].
    pub code: &'static str,
    /// Meaning in a few words.
    pub title: &'static str,
    /// Sections in Markdown, without headings.
    pub sections: Vec<&'static str>,
}

impl Page {
    /// Returns all sections in Markdown.
    pub fn text(&self) -> String {
        self.sections.join("\n\n") + "\n"
    }

    /// Returns all sections for a terminal. Code blocks are indented instead of fenced; prose is unchanged.
    pub fn plain(&self) -> String {
        let (mut out, mut fenced) = (String::new(), false);
        for line in self.text().lines() {
            if line.starts_with("```") {
                fenced = !fenced;
                continue;
            }
            if fenced && !line.is_empty() {
                out += "    ";
            }
            out += line;
            out += "\n";
        }
        out
    }
}

/// Returns the page of a code, in upper or lower case; `None` for an unknown code.
pub fn page(code: &str) -> Option<Page> {
    let &(code, title) = CODES.iter().find(|c| c.0.eq_ignore_ascii_case(code))?;
    let mut all = Vec::new();
    for file in FILES {
        sections(file, code, &mut all);
    }
    Some(Page { code, title, sections: all })
}

/// Returns the severity of a code, by its letter.
pub fn severity(code: &str) -> Severity {
    match code.as_bytes().first() {
        Some(b'E') => Severity::Error,
        Some(b'W') => Severity::Warning,
        _ => Severity::Note,
    }
}

/// Finds the sections about one code in a file. Headings inside code blocks do not count.
fn sections(file: &'static str, code: &str, found: &mut Vec<&'static str>) {
    let (mut at, mut start, mut fenced) = (0, None, false);
    for line in file.split_inclusive('\n') {
        if line.starts_with("```") {
            fenced = !fenced;
        } else if let (false, Some(heading)) = (fenced, line.strip_prefix("## ")) {
            found.extend(start.map(|from| file[from..at].trim()));
            start = (heading.split_whitespace().next() == Some(code)).then_some(at + line.len());
        }
        at += line.len();
    }
    found.extend(start.map(|from| file[from..].trim()));
}
