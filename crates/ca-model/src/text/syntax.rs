//! Reports text that is not TOML, repairs usual slips and continues.
//!
//! A missing `"`, `}` or `]` is inserted before parsing. Since TOML 1.1 inline tables may span lines, so otherwise one
//! missing `}` would swallow the rest of the file, and every link to a module below would be "unknown". A model has one
//! module on a line: a new `name =` or `[SECTION]` after a line that does not end in a comma shows where the table
//! should have ended. Spans are corrected, so reports point into the text as written. Valid TOML is not changed.
//!
//! The pass also counts brackets. After errors the parser's protection against deep nesting can fail, and a hostile
//! file would overflow the stack. A text nested deeper than [`DEEP`] is not parsed. The first place that TOML 1.0
//! refuses is recorded too (`toml_1_1.rs`).

use super::blocks::{Cut, Cutter};
use super::toml_1_1::Newer;
use crate::diag::{Diag, Diags};
use crate::model::LARGEST;
use crate::model::Span;
use crate::select::{is_name, is_word};
use alloc::borrow::Cow;
use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_core::Catalog;
use core::ops::Range;
use toml::de::{DeTable, DeValue, Error};

/// Text for the parser, with the mapping to the text as written.
pub(crate) struct Source<'s> {
    text: Cow<'s, str>,
    /// Offset of each inserted byte in the repaired text, ascending.
    inserted: Vec<usize>,
    /// For a part of a text: start of each piece, and its offset in the repaired text.
    pieces: Vec<(usize, usize)>,
    /// Cuts of a long text, as offsets in the repaired text.
    pub(super) cuts: Vec<Cut>,
    /// First construct that requires TOML 1.1.
    pub(super) newer: Option<Newer>,
}

impl<'s> Source<'s> {
    /// Returns the text itself if brackets and quotes pair, otherwise a repaired copy, and reports the repairs.
    pub(crate) fn mend(text: &'s str, catalog: &Catalog, diags: &mut Diags) -> Source<'s> {
        let mut brackets = Brackets {
            text,
            catalog,
            at: 0,
            open: Vec::new(),
            edits: Vec::new(),
            solid: 0,
            cutter: Cutter::default(),
            newer: None,
        };
        let plain = |text, cuts, newer| Source {
            text: Cow::Borrowed(text),
            inserted: Vec::new(),
            pieces: Vec::new(),
            cuts,
            newer,
        };
        if !brackets.run(diags) || diags.is_full() {
            return plain("", Vec::new(), None);
        }
        let (mut edits, mut cuts) = (brackets.edits, brackets.cutter.cuts);
        if edits.is_empty() {
            return plain(text, cuts, brackets.newer);
        }
        edits.sort_by_key(|e| e.0);
        let (mut mended, mut inserted, mut from) = (String::new(), Vec::new(), 0);
        for (at, closer) in edits {
            mended.push_str(&text[from..at]);
            inserted.push(mended.len());
            mended.push(closer);
            from = at;
        }
        mended.push_str(&text[from..]);
        let places: Vec<usize> = inserted.iter().enumerate().map(|(i, at)| at - i).collect();
        // a character inserted at a place stands before it
        let moved = |at: usize| at + places.partition_point(|&p| p <= at);
        for c in &mut cuts {
            c.header = moved(c.header.start)..moved(c.header.end);
            c.body = moved(c.body.start)..moved(c.body.end);
        }
        Source { text: Cow::Owned(mended), inserted, pieces: Vec::new(), cuts, newer: None }
    }

    /// Returns the parts of a cut text: the remainder, then one for each cut.
    pub(crate) fn parts(&self) -> impl Iterator<Item = Source<'static>> + '_ {
        let text = self.text();
        let whole = core::iter::once_with(move || {
            let (mut kept, mut pieces, mut from) = (String::new(), Vec::new(), 0);
            for to in self.cuts.iter().map(|c| c.body.clone()).chain(core::iter::once(text.len()..text.len())) {
                pieces.push((kept.len(), from));
                kept.push_str(text.get(from..to.start).unwrap_or(""));
                from = to.end;
            }
            self.part(kept, pieces)
        });
        let of_cut = move |c: &Cut| {
            let header = text.get(c.header.clone()).unwrap_or("");
            let body = text.get(c.body.clone()).unwrap_or("");
            let pieces = Vec::from([(0, c.header.start), (header.len() + 1, c.body.start)]);
            self.part([header, "\n", body].concat(), pieces)
        };
        whole.chain(self.cuts.iter().map(of_cut))
    }

    fn part(&self, text: String, pieces: Vec<(usize, usize)>) -> Source<'static> {
        Source { text: Cow::Owned(text), inserted: self.inserted.clone(), pieces, cuts: Vec::new(), newer: None }
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Converts a range of the repaired text to a span of the text as written.
    pub(crate) fn span(&self, r: Range<usize>) -> Span {
        let whole = |at: usize| {
            let piece = self.pieces.partition_point(|p| p.0 <= at).checked_sub(1).and_then(|i| self.pieces.get(i));
            piece.map_or(at, |p| at - p.0 + p.1)
        };
        let back = |at: usize| at - self.inserted.partition_point(|&i| i < at);
        // the end of a piece is not the start of the next
        let end = if r.end > r.start { whole(r.end - 1) + 1 } else { whole(r.start) };
        Span { start: back(whole(r.start)), end: back(end) }
    }
}

/// Largest nesting of brackets: far more than a model needs, and safe for the stack.
const DEEP: usize = 64;

/// Largest number of broken lines that are reported. With more, the file is probably not a model.
const BROKEN: usize = 100;

/// Converts parser errors to findings: only the first on each line, since the others are often its consequences.
pub(crate) fn report(source: &Source, text: &str, doc: &DeTable, errors: &[Error], diags: &mut Diags) {
    if errors.is_empty() {
        return;
    }
    let breaks: Vec<usize> = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i).collect();
    let line = |span: Span| breaks.partition_point(|&b| b < span.start);
    let mut broken: BTreeSet<usize> = diags.list.iter().flat_map(|d| d.labels.iter().map(|l| line(l.0))).collect();
    let mut twice = 0;
    for e in errors {
        if broken.len() + twice > BROKEN {
            break;
        }
        let span = e.span().map_or(Span { start: text.len(), end: text.len() }, |r| source.span(r));
        let written = text.get(span.start..span.end).unwrap_or("");
        if e.message() == "duplicate key" {
            diags.push(duplicate(source, text, doc, span, written));
            twice += 1;
            continue;
        }
        if e.message().starts_with("string values must be quoted")
            && !written.is_empty()
            && !written.contains(['"', '\\'])
        {
            let d = Diag::error("E001", "not TOML: a string without quotes").at(span, "missing quotes");
            diags.push(d.help("put a value with a unit in quotes").fix(span, format!("\"{written}\"")));
            continue;
        }
        // a name in other letters is read, and refused as a name later
        if e.message().starts_with("invalid unquoted key") && written.chars().all(char::is_alphabetic) {
            continue;
        }
        if !broken.insert(line(span)) {
            continue;
        }
        let (what, expected) = e.message().split_once(", expected ").unwrap_or((e.message(), ""));
        let label = if expected.is_empty() { String::new() } else { format!("expected {expected}") };
        diags.push(Diag::error("E001", format!("not TOML: {what}")).at(span, label));
    }
}

fn duplicate(source: &Source, text: &str, doc: &DeTable, span: Span, written: &str) -> Diag {
    let header = |l: &str| l.trim().strip_prefix('[')?.split_once(']').map(|(inside, _)| inside.trim().len());
    let start = text[..span.start.min(text.len())].rfind('\n').map_or(0, |i| i + 1);
    let this = text[start..].lines().next().unwrap_or("").trim();
    if header(this).is_some() {
        let mut at = 0;
        let mut first = None;
        for l in text[..start].split_inclusive('\n') {
            if first.is_none() && header(l).is_some() && l.trim() == this {
                let lead = l.len() - l.trim_start().len();
                first = Some(Span { start: at + lead, end: at + lead + this.len() });
            }
            at += l.len();
        }
        let d = Diag::error("E012", format!("the section `{this}` is written twice")).at(span, "again here");
        let d = match first {
            Some(f) => d.at(f, "first here"),
            None => d,
        };
        return d.help("TOML allows each section only once: move these lines to the first");
    }
    let mut first = None;
    last_key_before(source, doc, written, span, &mut first);
    let d = Diag::error("E012", format!("`{written}` is written twice")).at(span, "again here");
    let d = match first {
        Some(f) => d.at(f, "first here"),
        None => d,
    };
    d.help("the first one is used: remove or rename the second")
}

/// Finds the last key of that name before `before`, which is the repeated one, since both are in the same table.
fn last_key_before(source: &Source, table: &DeTable, name: &str, before: Span, best: &mut Option<Span>) {
    for (k, v) in table {
        let span = source.span(k.span());
        if k.get_ref() == name && span < before && best.is_none_or(|b| b < span) {
            *best = Some(span);
        }
        if let DeValue::Table(inner) = v.get_ref() {
            last_key_before(source, inner, name, before, best);
        }
    }
}

struct Brackets<'s> {
    text: &'s str,
    catalog: &'s Catalog,
    at: usize,
    /// Open brackets: place and closing character.
    open: Vec<(usize, char)>,
    edits: Vec<(usize, char)>,
    /// End of the last character that is neither blank nor comment.
    solid: usize,
    cutter: Cutter,
    newer: Option<Newer>,
}

impl<'s> Brackets<'s> {
    /// Finds the characters to insert. Returns false for a text that is nested too deep or has too many modules.
    fn run(&mut self, diags: &mut Diags) -> bool {
        // the byte before `solid`, and whether the line is blank so far
        let (mut last, mut fresh) = (b'\n', true);
        while let Some(&b) = self.text.as_bytes().get(self.at) {
            match b {
                b'\n' => {
                    fresh = true;
                    if let Some(&(at, '}')) = self.open.last() {
                        self.newer.get_or_insert(Newer::Lines(at));
                    }
                }
                b' ' | b'\t' | b'\r' => {}
                b'#' => self.at = self.line_end() - 1,
                _ => {
                    if fresh && !self.open.is_empty() && !b",{[".contains(&last) && self.is_statement() {
                        self.close(0, diags);
                    }
                    if fresh && self.open.is_empty() {
                        self.equals(diags);
                    }
                    if fresh && self.open.is_empty() && b == b'[' {
                        let line = self.line();
                        self.cutter.section(self.at, line, self.catalog);
                        self.header(diags);
                    } else {
                        if fresh && self.open.is_empty() && self.cutter.module(self.at) > LARGEST {
                            let d = Diag::error("E027", format!("more than {LARGEST} masses and links are written"));
                            let d = d.at(Span { start: self.at, end: self.at + 1 }, "limit exceeded here");
                            let fewer = "use fewer modules; for real time, a few thousand";
                            diags.push(d.help(fewer));
                            return false;
                        }
                        self.token(b, diags);
                    }
                    if self.open.len() > DEEP {
                        let d = Diag::error("E001", "not TOML: nested too deep");
                        diags.push(d.at(Span { start: self.at, end: self.at + 1 }, format!("more than {DEEP} levels")));
                        return false;
                    }
                    fresh = false;
                    self.solid = self.at + 1;
                    last = self.text.as_bytes().get(self.at).copied().unwrap_or(b' ');
                }
            }
            self.at += 1;
        }
        if !self.open.is_empty() {
            self.close(0, diags);
        }
        self.cutter.section(self.text.len(), "", self.catalog);
        true
    }

    fn line_end(&self) -> usize {
        let end = self.text.as_bytes()[self.at..].iter().position(|&b| b == b'\n');
        end.map_or(self.text.len(), |i| self.at + i)
    }

    fn line(&self) -> &'s str {
        self.text.get(self.at..self.line_end()).unwrap_or("")
    }

    /// Returns true if a module or a section starts here.
    fn is_statement(&self) -> bool {
        let line = self.line();
        if let Some(rest) = line.strip_prefix('[') {
            let name = rest.split([']', '#']).next().unwrap_or("");
            return name.split('.').all(|w| is_word(w.trim()));
        }
        line.split_once('=').is_some_and(|(key, _)| is_name(key.trim()))
    }

    /// Closes all brackets above the first `keep`, behind the last character written.
    fn close(&mut self, keep: usize, diags: &mut Diags) {
        let end = self.solid.min(self.text.len());
        let last = self.open.get(keep..).and_then(<[_]>::last).copied();
        let closers: String = self.open.drain(keep..).rev().map(|o| o.1).collect();
        if let Some((at, closer)) = last {
            let opener = if closer == '}' { '{' } else { '[' };
            let d = Diag::error("E001", format!("not TOML: `{opener}` is not closed"));
            let d = d.at(Span { start: at, end: at + 1 }, format!("`{closer}` is missing"));
            let gap = if closer == '}' { " " } else { "" };
            diags.push(d.fix(Span { start: end, end }, format!("{gap}{closers}")));
        }
        self.edits.extend(closers.chars().map(|c| (end, c)));
    }

    /// Adds a missing `]` to `[SECTION]`. The line is then read as usual.
    fn header(&mut self, diags: &mut Diags) {
        let line = self.line().split('#').next().unwrap_or("").trim_end();
        let (start, end) = (self.at, self.at + line.len());
        if !line.contains([']', '"', '\'']) {
            let d =
                Diag::error("E001", "not TOML: `[` is not closed").at(Span { start, end: start + 1 }, "`]` is missing");
            diags.push(d.fix(Span { start: end, end }, "]"));
            self.edits.push((end, ']'));
        }
    }

    /// Adds a missing `=` to `name { … }`.
    fn equals(&mut self, diags: &mut Diags) {
        let Some((key, _)) = self.line().split_once('{') else { return };
        let name = key.trim_end();
        if is_name(name) {
            let (start, at) = (self.at, self.at + name.len());
            let d =
                Diag::error("E001", "not TOML: `=` is missing").at(Span { start, end: at }, "this name has no value");
            diags.push(d.fix(Span { start: at, end: at }, " ="));
            self.edits.push((at, '='));
        }
    }

    fn token(&mut self, b: u8, diags: &mut Diags) {
        match b {
            b'{' => self.open.push((self.at, '}')),
            b'[' => self.open.push((self.at, ']')),
            b'}' | b']' if self.open.last().is_some_and(|o| o.1 == char::from(b)) => {
                self.open.pop();
                let before = self.solid.saturating_sub(1);
                if b == b'}' && self.text.as_bytes().get(before) == Some(&b',') {
                    self.newer.get_or_insert(Newer::Comma(before));
                }
            }
            // `[1, 2 }`: brackets opened inside end here
            b'}' | b']' => {
                if let Some(keep) = self.open.iter().rposition(|o| o.1 == char::from(b)) {
                    self.close(keep + 1, diags);
                    self.open.pop();
                }
            }
            b'"' | b'\'' => {
                let start = self.at;
                self.string(b, diags);
                if b == b'"' && self.newer.is_none() {
                    self.newer = Newer::escape(self.text, start, self.at);
                }
            }
            _ => {}
        }
    }

    /// Steps to the closing quote, or adds a missing one.
    fn string(&mut self, quote: u8, diags: &mut Diags) {
        let bytes = self.text.as_bytes();
        let start = self.at;
        if bytes[start..].starts_with(&[quote; 3]) {
            let mut i = start + 3;
            while i < bytes.len() && !bytes[i..].starts_with(&[quote; 3]) {
                i += if quote == b'"' && bytes[i] == b'\\' { 2 } else { 1 };
            }
            // up to two more quotes belong to the text
            let more = bytes.get(i + 3..).unwrap_or(&[]).iter().take(2).take_while(|&&b| b == quote).count();
            self.at = (i + 2 + more).min(bytes.len() - 1);
            return;
        }
        let mut i = start + 1;
        while i < bytes.len() && bytes[i] != quote && bytes[i] != b'\n' {
            i += if quote == b'"' && bytes[i] == b'\\' && bytes.get(i + 1) != Some(&b'\n') { 2 } else { 1 };
        }
        if bytes.get(i) == Some(&quote) {
            self.at = i;
            return;
        }
        let end = i.min(bytes.len());
        // not closed on its line: it ends before the closing brackets of the line
        let body = self.text.get(start + 1..end).unwrap_or("");
        let keep = body.trim_end_matches(|c: char| c.is_whitespace() || matches!(c, '}' | ']' | ',' | '\\'));
        let at = start + 1 + keep.len();
        let d = Diag::error("E001", "not TOML: a string is not closed")
            .at(Span { start, end: at }, "the closing quote is missing");
        let d = d.help("close it with the same quote as at its start");
        diags.push(d.fix(Span { start: at, end: at }, char::from(quote)));
        self.edits.push((at, char::from(quote)));
        self.at = at - 1;
    }
}
