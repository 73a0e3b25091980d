//! The page of a diagnostic: what its code means, shown by models that have the finding and by the report of each.
//!
//! Decides that the pages are files of this crate (`diagnostics/*.md`), compiled in, so that a program explains the codes
//! of its own version without a network or a folder beside it. A file is about one subject and has a section
//! `## E013 unknown name` for each code met there; the page of a code is all its sections. A test of the workspace checks
//! that every code has one and that every report shown is the one that is made.

use super::diag::{CODES, Severity};
use alloc::string::String;
use alloc::vec::Vec;

/// In the order in which an author meets them.
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

/// All that is written about one code.
#[derive(Clone, Debug)]
pub struct Page {
    /// the code, an entry of [`CODES`]
    pub code: &'static str,
    /// what it means in a few words
    pub title: &'static str,
    /// its sections in Markdown, without headings
    pub sections: Vec<&'static str>,
}

impl Page {
    /// The sections in one piece of Markdown.
    pub fn text(&self) -> String {
        self.sections.join("\n\n") + "\n"
    }

    /// The sections for a terminal: blocks of code are indented in place of their fences, prose is as it was written.
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

/// The page of a code, in upper or lower case; `None` where there is no such code.
pub fn page(code: &str) -> Option<Page> {
    let &(code, title) = CODES.iter().find(|c| c.0.eq_ignore_ascii_case(code))?;
    let mut all = Vec::new();
    for file in FILES {
        sections(file, code, &mut all);
    }
    Some(Page { code, title, sections: all })
}

/// How bad the findings of a code are, as its letter says.
pub fn severity(code: &str) -> Severity {
    match code.as_bytes().first() {
        Some(b'E') => Severity::Error,
        Some(b'W') => Severity::Warning,
        _ => Severity::Note,
    }
}

/// The sections of a file about one code. What looks like a heading within a block of code is none.
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
