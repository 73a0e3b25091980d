//! Replacements that set, insert and remove entries of a text, in the style of the lines beside them.

use crate::TextEdit;
use crate::paths::Paths;
use crate::tree::{Content, Header, Node, Pair, Statement, Tree, is_header};
use ca_core::internal::kind::PortRole;
use ca_core::{Catalog, Role};
use core::ops::Range;

/// A text with its statements.
#[derive(Clone, Copy)]
pub(crate) struct Layout<'t> {
    pub text: &'t str,
    pub tree: &'t Tree,
    /// Kinds, by which a new section gets its usual place; without them it is the last.
    pub catalog: Option<&'t Catalog>,
}

/// Writes a key, in quotes where needed.
pub(crate) fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
    if !name.is_empty() && name.chars().all(bare) { name.into() } else { quoted(name) }
}

/// Writes a dotted key.
pub(crate) fn dotted(path: &[String]) -> String {
    path.iter().map(|k| key(k)).collect::<Vec<_>>().join(".")
}

/// Writes a text as a string of TOML.
pub(crate) fn quoted(text: &str) -> String {
    let plain = |c: char| !c.is_control();
    if text.chars().all(|c| plain(c) && !matches!(c, '"' | '\\')) {
        return format!("\"{text}\"");
    }
    if text.chars().all(|c| plain(c) && c != '\'') {
        return format!("'{text}'");
    }
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            '\n' => out += "\\n",
            '\r' => out += "\\r",
            '\t' => out += "\\t",
            c if c.is_control() => out.extend(format!("\\u{:04X}", c as u32).chars()),
            c => out.push(c),
        }
    }
    out + "\""
}

impl<'t> Layout<'t> {
    /// Returns the line end of the text.
    pub fn eol(self) -> &'static str {
        if self.text.contains("\r\n") { "\r\n" } else { "\n" }
    }

    pub fn line_start(self, at: usize) -> usize {
        self.text[..at].rfind('\n').map_or(0, |i| i + 1)
    }

    /// Returns the end of the line, behind its line end.
    pub fn line_end(self, at: usize) -> usize {
        self.text[at..].find('\n').map_or(self.text.len(), |i| at + i + 1)
    }

    /// Returns the whole lines of a range.
    pub fn lines(self, range: &Range<usize>) -> Range<usize> {
        self.line_start(range.start)..self.line_end(range.end)
    }

    /// Inserts lines, each without its line end, at the start of a line or the end of the text.
    pub fn insert_lines(self, at: usize, lines: &str) -> TextEdit {
        let eol = self.eol();
        let open = at > 0 && !self.text[..at].ends_with('\n');
        TextEdit::insert(at, format!("{}{lines}{eol}", if open { eol } else { "" }))
    }

    /// Sets the value at `path`, written as `new`, or inserts it. Returns `None` if a table of the path is a value, or the
    /// value a section.
    pub fn set(self, path: &[String], new: &str) -> Option<TextEdit> {
        match self.tree.pair(path) {
            Some(p) => Some(TextEdit::new(p.value.range.clone(), new)),
            None if self.tree.is_table(path) => None,
            None => self.insert(path, new),
        }
    }

    fn insert(self, path: &[String], new: &str) -> Option<TextEdit> {
        let (name, owner) = path.split_last()?;
        // the nearest value around it, which must be an inline table
        if let Some(p) = (1..path.len()).rev().find_map(|n| self.tree.pair(&path[..n])) {
            let Content::Table(inner) = &p.value.content else { return None };
            return Some(self.into_inline(&p.value, inner, &path[p.path.len()..], new));
        }
        let line = format!("{} = {new}", key(name));
        if let Some(h) = self.tree.headers().find(|h| is_header(h, owner)) {
            let (at, indent) = self.block_end(h);
            return Some(self.insert_lines(at, &format!("{indent}{line}")));
        }
        // words of the owner before the last ones of the path, such as `with` of `with.f`
        let own = |p: &Pair| p.words.len().saturating_sub(p.path.len().saturating_sub(owner.len()));
        let is_dotted = |p: &&Pair| p.path.len() > owner.len() && p.path.starts_with(owner) && own(p) > 0;
        if let Some(p) = self.tree.pairs().rfind(is_dotted) {
            let before = &self.text[p.words[0].range.start..p.words[own(p) - 1].range.end];
            let at = self.line_end(p.range().end);
            return Some(self.insert_lines(at, &format!("{}{before}.{line}", self.indent(p.range().start))));
        }
        if owner.is_empty() {
            return Some(self.insert_lines(self.first_header(), &line));
        }
        // a gesture is one line with its full name
        let root = if owner[0] == "part" { 2 } else { 0 };
        if owner.get(root).is_some_and(|word| word == "gesture") {
            let (section, names) = path.split_at(root + 1);
            let line = format!("{} = {new}", dotted(names));
            if let Some(h) = self.tree.headers().find(|h| is_header(h, section)) {
                let (at, indent) = self.block_end(h);
                return Some(self.insert_lines(at, &format!("{indent}{line}")));
            }
            return Some(self.section(section, &line, self.after_relatives(section)));
        }
        Some(self.section(owner, &line, self.after_relatives(owner)))
    }

    fn into_inline(self, table: &Node, inner: &[Pair], rest: &[String], new: &str) -> TextEdit {
        // written as its neighbours are: `with.f = 1` or `with = { f = 1 }`
        let level = table_level(inner);
        let is_dotted =
            |n: usize| inner.iter().any(|p| p.words.len() > n && p.path.get(level..level + n) == rest.get(..n));
        let dots = (1..rest.len()).take_while(|n| is_dotted(*n)).count();
        let (first, nested) = rest.split_at(dots + 1);
        let open: String = nested.iter().flat_map(|k| ["{ ".into(), key(k), " = ".into()]).collect();
        let entry = format!("{} = {open}{new}{}", dotted(first), " }".repeat(nested.len()));
        if let Some(last) = inner.last() {
            return TextEdit::insert(last.value.range.end, format!(", {entry}"));
        }
        let within = table.range.start + 1..table.range.end - 1;
        let blank = self.text[within.clone()].trim().is_empty();
        TextEdit::new(if blank { within.clone() } else { within.start..within.start }, format!(" {entry} "))
    }

    /// Returns the place behind the last entry of a section, and the indentation of its lines.
    fn block_end(self, header: &Header) -> (usize, &'t str) {
        let from = self.tree.statements.iter().position(|s| s.range() == header.range).map_or(0, |i| i + 1);
        let block = self.tree.statements[from..].iter();
        let last = block.map_while(|s| if let Statement::Pair(p) = s { Some(p) } else { None }).last();
        let end = last.map_or(header.range.clone(), Pair::range);
        (self.line_end(end.end), self.indent(end.start))
    }

    fn indent(self, at: usize) -> &'t str {
        let line = &self.text[self.line_start(at)..at];
        &line[..line.len() - line.trim_start().len()]
    }

    /// Returns the place before the first section and the comments above it.
    fn first_header(self) -> usize {
        match self.tree.statements.first() {
            Some(Statement::Pair(_)) => {
                let last = self.tree.statements.iter().take_while(|s| matches!(s, Statement::Pair(_))).last();
                last.map_or(0, |s| self.line_end(s.range().end))
            }
            Some(Statement::Header(h)) => self.line_start(h.range.start),
            None => self.text.len(),
        }
    }

    /// Returns the place behind the sections with the longest common start, or the usual place of the section.
    pub fn after_relatives(self, path: &[String]) -> usize {
        let below = |n: usize| self.tree.statements.iter().rfind(|s| s.is_below(&path[..n]));
        match (1..path.len()).rev().find_map(below) {
            Some(s) => self.line_end(s.range().end),
            None => self.usual_place(path.first().map_or("", |word| word)),
        }
    }

    /// Returns the place of a new root section: behind the last one of its rank or a lower one.
    fn usual_place(self, section: &str) -> usize {
        let Some(catalog) = self.catalog else { return self.text.len() };
        let mine = rank(section, catalog);
        let (mut at, mut last) = (None, None);
        for s in &self.tree.statements {
            if let Statement::Header(h) = s {
                last = h.words.first().map(|w| rank(&w.name, catalog));
            }
            if last.is_some_and(|r| r <= mine) {
                at = Some(self.line_end(s.range().end));
            }
        }
        at.unwrap_or_else(|| match self.tree.headers().next() {
            Some(h) => self.line_start(h.range.start),
            None => self.text.len(),
        })
    }

    /// Inserts the section `path` with `lines`, at the start of a line or the end of the text.
    pub fn section(self, path: &[String], lines: &str, at: usize) -> TextEdit {
        let eol = self.eol();
        let (before, after) = self.text.split_at(at);
        let gap = if before.trim_start_matches('\u{feff}').is_empty() { "" } else { eol };
        let tail = if after.is_empty() || after.starts_with(['\n', '\r']) { "" } else { eol };
        let lines = if lines.is_empty() { String::new() } else { format!("{eol}{lines}") };
        self.insert_lines(at, &format!("{gap}[{}]{lines}{}", dotted(path), tail))
    }

    /// Removes everything at and below the paths, and sections that become empty, unless a comment is in them.
    pub fn remove(self, paths: &Paths) -> Vec<TextEdit> {
        self.remove_entries(paths, true)
    }

    /// Removes everything at and below the paths. `empty` says whether sections that become empty are removed too.
    pub fn remove_entries(self, paths: &Paths, empty: bool) -> Vec<TextEdit> {
        let gone = |s: &Statement| paths.cover_statement(s);
        let mut edits = Vec::new();
        for block in self.blocks() {
            let [first, entries @ ..] = block else { continue };
            let is_header = matches!(first, Statement::Header(_));
            let all = entries.iter().all(gone);
            let last = block.last().unwrap_or(first).range().end;
            let whole = self.line_start(first.range().start)..self.line_end(last);
            if is_header && gone(first) {
                edits.push(TextEdit::new(self.with_blank(whole), ""));
                continue;
            }
            let comments = &self.tree.comments;
            let comments = &comments[comments.partition_point(|c| c.start < whole.start)..];
            let mut comments = comments.iter().take_while(|c| c.start < whole.end);
            let emptied = empty && is_header && all && !entries.is_empty();
            if emptied && comments.all(|c| self.is_on(c, entries)) {
                edits.push(TextEdit::new(self.with_blank(whole), ""));
                continue;
            }
            for s in block.iter().filter(|s| matches!(s, Statement::Pair(_))) {
                if gone(s) {
                    edits.push(TextEdit::new(self.lines(&s.range()), ""));
                } else if let Statement::Pair(p) = s {
                    self.remove_inline(p, paths, &mut edits);
                }
            }
        }
        edits
    }

    /// Returns the statements as sections: each begins with its header, the first perhaps without one.
    fn blocks(self) -> impl Iterator<Item = &'t [Statement]> {
        let mut rest = self.tree.statements.as_slice();
        core::iter::from_fn(move || {
            let n = rest.iter().skip(1).position(|s| matches!(s, Statement::Header(_))).map_or(rest.len(), |i| i + 1);
            let (block, after) = rest.split_at(n);
            rest = after;
            (!block.is_empty()).then_some(block)
        })
    }

    fn is_on(self, comment: &Range<usize>, entries: &[Statement]) -> bool {
        let before = entries.partition_point(|s| s.range().start <= comment.start);
        let entry = before.checked_sub(1).and_then(|i| entries.get(i));
        entry.is_some_and(|s| comment.start < self.line_end(s.range().end))
    }

    /// Adds a blank line behind removed lines, unless the text before does not end with one.
    fn with_blank(self, lines: Range<usize>) -> Range<usize> {
        let before = self.text[..lines.start].trim_end_matches([' ', '\t']);
        let after = self.line_end(lines.end);
        let blank = self.text[lines.end..after].trim().is_empty();
        let ends = before.is_empty() || before.ends_with("\n\n") || before.ends_with("\n\r\n");
        if blank && ends { lines.start..after } else { lines }
    }

    fn remove_inline(self, pair: &Pair, paths: &Paths, edits: &mut Vec<TextEdit>) {
        let Content::Table(inner) = &pair.value.content else { return };
        let mut kept = false;
        for (i, p) in inner.iter().enumerate() {
            if !paths.cover(&p.path) {
                kept = true;
                self.remove_inline(p, paths, edits);
                continue;
            }
            let range = self.member(&pair.value, i, inner.len(), kept, |i| inner[i].range());
            edits.push(TextEdit::new(range, ""));
        }
    }

    /// Removes one value of a list.
    pub fn remove_member(self, list: &Node, i: usize) -> Option<TextEdit> {
        let Content::List(all) = &list.content else { return None };
        let range = all.get(i).map(|_| self.member(list, i, all.len(), i > 0, |i| all[i].range.clone()))?;
        Some(TextEdit::new(range, ""))
    }

    /// Returns the range of a member with one comma: the one before it if a member before stays.
    fn member(self, of: &Node, i: usize, n: usize, kept: bool, at: impl Fn(usize) -> Range<usize>) -> Range<usize> {
        let this = at(i);
        if kept {
            return at(i - 1).end..this.end;
        }
        if i + 1 < n {
            return this.start..at(i + 1).start;
        }
        let comma = self.text[this.end..of.range.end].trim_start();
        let end = if comma.starts_with(',') { of.range.end - comma.len() + 1 } else { this.end };
        this.start..end
    }
}

/// Returns the rank of a root section in the usual order of a model.
fn rank(name: &str, catalog: &Catalog) -> u8 {
    match name {
        "model" => 0,
        "rate" => 1,
        "param" => 2,
        "preset" => 3,
        "gesture" => 8,
        "equivalence" => 9,
        _ => match catalog.get(name).map(|k| k.role) {
            Some(Role::Lia(_)) => 6,
            Some(Role::Port(PortRole::Sox | PortRole::Sof)) => 7,
            // masses, generators, ports, groups, parts and instances
            _ => 5,
        },
    }
}

/// Returns the number of keys around the pairs of an inline table.
fn table_level(inner: &[Pair]) -> usize {
    inner.first().map_or(0, |p| p.path.len() - p.words.len())
}
