//! A long text in parts that are parsed one by one.
//!
//! Decides against parsing the whole at once: the parser keeps some 50 bytes for each byte of the text (tokens, events, a
//! table of fixed room for each module) until the last module is read. A section of a kind that is longer than [`BLOCK`]
//! is therefore cut between modules. What is cut off is parsed under its header again; the rest of the document stays
//! one, so that a section that is written twice is found as ever. Shorter texts are not cut at all.
//!
//! Counts modules too: more than a model holds are refused before any of them is parsed.

use crate::select::is_word;
use alloc::vec::Vec;
use ca_core::{Catalog, Role};
use core::ops::Range;

/// Bytes of a section that are parsed at once.
pub(super) const BLOCK: usize = 1 << 18;

/// What is cut off: where its header stands, and its modules.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cut {
    pub header: Range<usize>,
    pub body: Range<usize>,
}

/// Finds the cuts, given every section and every module in the order of the text.
#[derive(Default)]
pub(super) struct Cutter {
    pub cuts: Vec<Cut>,
    /// the header that may stand above a part of its modules, and where the part it is in begins
    section: Option<Range<usize>>,
    from: usize,
    /// whether its modules are masses or links
    counts: bool,
    modules: usize,
}

impl Cutter {
    /// A section begins, or the text ends.
    pub fn section(&mut self, at: usize, line: &str, catalog: &Catalog) {
        self.end(at);
        let name = line.strip_prefix('[').and_then(|l| l.split_once(']')).map_or("", |l| l.0.trim());
        let kind = catalog.get(name.rsplit('.').next().unwrap_or("").trim());
        self.counts = kind.is_some_and(|k| matches!(k.role, Role::Mat(_) | Role::Lia(_)));
        let header = line.find(']').map_or(line.len(), |i| i + 1);
        self.section = (kind.is_some() && is_word(name)).then_some(at..at + header);
        self.from = at;
    }

    /// A module begins; how many masses and links there are with it.
    pub fn module(&mut self, at: usize) -> usize {
        if let Some(header) = self.section.clone()
            && at - self.from > BLOCK
        {
            self.end(at);
            self.cuts.push(Cut { header, body: at..at });
            self.from = at;
        }
        self.modules += usize::from(self.counts);
        self.modules
    }

    fn end(&mut self, at: usize) {
        if let Some(cut) = self.cuts.last_mut().filter(|c| c.body.is_empty()) {
            cut.body.end = at;
        }
    }
}
