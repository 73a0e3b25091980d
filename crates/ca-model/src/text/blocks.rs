//! Cuts a long text into parts that are parsed one by one.
//!
//! The parser keeps some 50 bytes for each byte of the text (tokens, events, a table of fixed size for each module)
//! until the last module is read. So a section of a kind that is longer than [`BLOCK`] is cut between modules, and each
//! piece is parsed under a copy of its header. The rest of the document stays in one piece, so that duplicate sections
//! are still found. Shorter texts are not cut. Modules are counted too, to refuse an oversized model before parsing.

use crate::select::is_word;
use alloc::vec::Vec;
use ca_core::{Catalog, Role};
use core::ops::Range;

/// Bytes of a section that are parsed at once.
pub(super) const BLOCK: usize = 1 << 18;

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cut {
    pub header: Range<usize>,
    pub body: Range<usize>,
}

/// Finds the cuts from every section and module, in the order of the text.
#[derive(Default)]
pub(super) struct Cutter {
    pub cuts: Vec<Cut>,
    /// Header of the current section if it can be cut; `from` is the start of the current piece.
    section: Option<Range<usize>>,
    from: usize,
    /// True if its modules are masses or links.
    counts: bool,
    modules: usize,
}

impl Cutter {
    /// Marks the start of a section, or the end of the text.
    pub fn section(&mut self, at: usize, line: &str, catalog: &Catalog) {
        self.end(at);
        let name = line.strip_prefix('[').and_then(|l| l.split_once(']')).map_or("", |l| l.0.trim());
        let kind = catalog.get(name.rsplit('.').next().unwrap_or("").trim());
        self.counts = kind.is_some_and(|k| matches!(k.role, Role::Mat(_) | Role::Lia(_)));
        let header = line.find(']').map_or(line.len(), |i| i + 1);
        self.section = (kind.is_some() && is_word(name)).then_some(at..at + header);
        self.from = at;
    }

    /// Marks the start of a module and returns the number of masses and links so far.
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
