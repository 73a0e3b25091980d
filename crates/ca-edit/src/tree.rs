//! The text of a model as statements with their byte ranges, in the order of the text.
//!
//! `toml_edit` keeps comments, but it moves dotted keys together and writes other line ends, so a text changes beyond
//! the edit. This tree only reads: [`crate::layout`] computes replaced ranges from it, and all other bytes stay.

use crate::Unreadable;
use core::ops::Range;
use std::borrow::Cow;
use std::collections::HashSet;
use toml_parser::decoder::ScalarKind;
use toml_parser::parser::{Event, EventKind, RecursionGuard, parse_document};
use toml_parser::{ParseError, Source, Span};

/// Largest nesting of brackets, as in the reader of models.
const DEEP: u32 = 64;

/// One word of a dotted key.
#[derive(Clone, Debug)]
pub(crate) struct Word {
    pub name: String,
    /// Range with quotes.
    pub range: Range<usize>,
}

/// `[a.b]`.
#[derive(Clone, Debug)]
pub(crate) struct Header {
    pub words: Vec<Word>,
    /// Range with brackets.
    pub range: Range<usize>,
}

/// `key = value`.
#[derive(Clone, Debug)]
pub(crate) struct Pair {
    /// Keys from the root of the file to the value.
    pub path: Vec<String>,
    /// The written words, the last ones of `path`.
    pub words: Vec<Word>,
    pub value: Node,
}

impl Pair {
    pub fn range(&self) -> Range<usize> {
        self.words.first().map_or(self.value.range.start, |w| w.range.start)..self.value.range.end
    }
}

/// A value with its range.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub range: Range<usize>,
    pub content: Content,
}

#[derive(Clone, Debug)]
pub(crate) enum Content {
    Text(String),
    Number(f64),
    Bool,
    /// A date, which no model can have.
    Other,
    List(Vec<Node>),
    Table(Vec<Pair>),
}

#[derive(Clone, Debug)]
pub(crate) enum Statement {
    Header(Header),
    Pair(Pair),
}

impl Statement {
    pub fn range(&self) -> Range<usize> {
        match self {
            Statement::Header(h) => h.range.clone(),
            Statement::Pair(p) => p.range(),
        }
    }

    /// Returns whether the statement is below `path`, or defines it.
    pub fn is_below(&self, path: &[String]) -> bool {
        match self {
            Statement::Header(h) => {
                h.words.len() >= path.len() && h.words.iter().zip(path).all(|(word, key)| word.name == *key)
            }
            Statement::Pair(p) => p.path.starts_with(path),
        }
    }
}

/// All statements of a text.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    pub statements: Vec<Statement>,
    /// Ranges of the comments, from `#` to the end of the line.
    pub comments: Vec<Range<usize>>,
}

impl Tree {
    /// Parses a text.
    pub fn read(text: &str) -> Result<Tree, Unreadable> {
        let source = Source::new(text);
        let tokens = source.lex().into_vec();
        let (mut events, mut errors) = (Vec::<Event>::new(), Vec::<ParseError>::new());
        parse_document(&tokens, &mut RecursionGuard::new(&mut events, DEEP), &mut errors);
        let mut builder = Builder { source, events: &events, at: 0, errors };
        let tree = builder.document();
        match builder.errors.first() {
            Some(e) => Err(Unreadable::new(text, e.unexpected().or(e.context()).map(|s| s.start()), e.description())),
            None => Ok(tree),
        }
    }

    pub fn pairs(&self) -> impl DoubleEndedIterator<Item = &Pair> {
        self.statements.iter().filter_map(|s| if let Statement::Pair(p) = s { Some(p) } else { None })
    }

    pub fn headers(&self) -> impl DoubleEndedIterator<Item = &Header> {
        self.statements.iter().filter_map(|s| if let Statement::Header(h) = s { Some(h) } else { None })
    }

    /// Returns the pair of a path, which may be within inline tables.
    pub fn pair(&self, path: &[String]) -> Option<&Pair> {
        find(self.pairs(), path)
    }

    /// Returns whether `path` is a section, an inline table, or the start of dotted keys.
    pub fn is_table(&self, path: &[String]) -> bool {
        match self.pair(path) {
            Some(p) => matches!(p.value.content, Content::Table(_)),
            None => path.is_empty() || !self.keys(path).is_empty() || self.headers().any(|h| is_header(h, path)),
        }
    }

    /// Returns the names of the keys directly below `path`, in the order of the text.
    pub fn keys<'t>(&'t self, path: &[String]) -> Vec<&'t str> {
        let (mut names, mut seen) = (Vec::new(), HashSet::new());
        let mut add = |name| {
            if seen.insert(name) {
                names.push(name);
            }
        };
        for s in self.statements.iter().filter(|s| s.is_below(path)) {
            match s {
                Statement::Header(h) => h.words.get(path.len()).into_iter().for_each(|w| add(w.name.as_str())),
                Statement::Pair(p) => p.path.get(path.len()).into_iter().for_each(|w| add(w.as_str())),
            }
        }
        for pairs in inline(self.pairs(), path) {
            pairs
                .iter()
                .filter(|p| p.path.starts_with(path))
                .filter_map(|p| p.path.get(path.len()))
                .for_each(|w| add(w.as_str()));
        }
        names
    }

    /// Calls `each` with the path of every written word and the word, those in inline tables too.
    pub fn words<'t>(&'t self, each: &mut dyn FnMut(&[String], &'t Word)) {
        for s in &self.statements {
            match s {
                Statement::Header(h) => {
                    let path: Vec<String> = h.words.iter().map(|w| w.name.clone()).collect();
                    h.words.iter().enumerate().for_each(|(i, w)| each(&path[..=i], w));
                }
                Statement::Pair(p) => words(p, each),
            }
        }
    }
}

fn find<'t>(mut pairs: impl Iterator<Item = &'t Pair>, path: &[String]) -> Option<&'t Pair> {
    pairs.find_map(|p| match &p.value.content {
        _ if p.path == path => Some(p),
        Content::Table(inner) if path.starts_with(&p.path) => find(inner.iter(), path),
        _ => None,
    })
}

/// Returns the inline tables that hold keys below `path`: its own, or one around dotted keys.
fn inline<'t>(pairs: impl Iterator<Item = &'t Pair>, path: &[String]) -> Vec<&'t [Pair]> {
    let mut all = Vec::new();
    for p in pairs.filter(|p| path.starts_with(&p.path)) {
        if let Content::Table(inner) = &p.value.content {
            all.push(inner.as_slice());
            all.extend(inline(inner.iter(), path));
        }
    }
    all
}

fn words<'t>(pair: &'t Pair, each: &mut dyn FnMut(&[String], &'t Word)) {
    let before = pair.path.len() - pair.words.len();
    pair.words.iter().enumerate().for_each(|(i, w)| each(&pair.path[..=before + i], w));
    if let Content::Table(inner) = &pair.value.content {
        for p in inner {
            words(p, each);
        }
    }
}

/// Returns whether a header is of exactly `path`.
pub(crate) fn is_header(header: &Header, path: &[String]) -> bool {
    header.words.iter().map(|w| &w.name).eq(path)
}

/// Reads one value that a text consists of.
pub(crate) fn value(text: &str) -> Option<Node> {
    // a line end or a comment would continue the document
    let tree = Tree::read(&format!("x = {text}")).ok()?;
    match tree.statements.as_slice() {
        [Statement::Pair(p)] if tree.comments.iter().all(|c| p.value.range.contains(&c.start)) => Some(p.value.clone()),
        _ => None,
    }
}

struct Builder<'e, 's> {
    source: Source<'s>,
    events: &'e [Event],
    at: usize,
    errors: Vec<ParseError>,
}

impl Builder<'_, '_> {
    fn next(&mut self) -> Option<Event> {
        let event = self.events.get(self.at).copied();
        self.at += 1;
        event
    }

    fn document(&mut self) -> Tree {
        let mut tree = Tree::default();
        let mut section: Vec<String> = Vec::new();
        let (mut words, mut open) = (Vec::new(), None);
        while let Some(e) = self.next() {
            match e.kind() {
                EventKind::StdTableOpen | EventKind::ArrayTableOpen => open = Some(e.span().start()),
                EventKind::StdTableClose | EventKind::ArrayTableClose => {
                    let range = open.take().unwrap_or(e.span().start())..e.span().end();
                    let words: Vec<Word> = core::mem::take(&mut words);
                    section = words.iter().map(|w| w.name.clone()).collect();
                    tree.statements.push(Statement::Header(Header { words, range }));
                }
                EventKind::SimpleKey => words.push(self.word(&e)),
                EventKind::KeyValSep => {
                    let words = core::mem::take(&mut words);
                    if let Some(pair) = self.pair(&section, words, &mut tree.comments) {
                        tree.statements.push(Statement::Pair(pair));
                    }
                }
                EventKind::Comment => tree.comments.push(range(e.span())),
                _ => {}
            }
        }
        tree
    }

    fn word(&mut self, e: &Event) -> Word {
        let mut name = String::new();
        if let Some(raw) = self.source.get(e) {
            let mut text = Cow::Borrowed("");
            raw.decode_key(&mut text, &mut self.errors);
            name = text.into_owned();
        }
        Word { name, range: range(e.span()) }
    }

    fn pair(&mut self, owner: &[String], words: Vec<Word>, comments: &mut Vec<Range<usize>>) -> Option<Pair> {
        let path: Vec<String> = owner.iter().cloned().chain(words.iter().map(|w| w.name.clone())).collect();
        let value = self.value(&path, comments)?;
        Some(Pair { path, words, value })
    }

    fn value(&mut self, path: &[String], comments: &mut Vec<Range<usize>>) -> Option<Node> {
        while let Some(e) = self.next() {
            match e.kind() {
                EventKind::Scalar => return Some(self.scalar(&e)),
                EventKind::ArrayOpen => return Some(self.list(&e, path, comments)),
                EventKind::InlineTableOpen => return Some(self.table(&e, path, comments)),
                EventKind::Comment => comments.push(range(e.span())),
                EventKind::Whitespace | EventKind::Newline => {}
                _ => {
                    self.at -= 1;
                    return None;
                }
            }
        }
        None
    }

    fn list(&mut self, open: &Event, path: &[String], comments: &mut Vec<Range<usize>>) -> Node {
        let (start, mut end, mut all) = (open.span().start(), open.span().end(), Vec::new());
        while let Some(e) = self.next() {
            end = e.span().end();
            match e.kind() {
                EventKind::ArrayClose => break,
                EventKind::Comment => comments.push(range(e.span())),
                EventKind::Scalar | EventKind::ArrayOpen | EventKind::InlineTableOpen => {
                    self.at -= 1;
                    all.extend(self.value(path, comments));
                }
                _ => {}
            }
        }
        Node { range: start..end, content: Content::List(all) }
    }

    fn table(&mut self, open: &Event, path: &[String], comments: &mut Vec<Range<usize>>) -> Node {
        let (start, mut end, mut all) = (open.span().start(), open.span().end(), Vec::new());
        let mut words = Vec::new();
        while let Some(e) = self.next() {
            end = e.span().end();
            match e.kind() {
                EventKind::InlineTableClose => break,
                EventKind::Comment => comments.push(range(e.span())),
                EventKind::SimpleKey => words.push(self.word(&e)),
                EventKind::KeyValSep => {
                    let words = core::mem::take(&mut words);
                    all.extend(self.pair(path, words, comments));
                }
                _ => {}
            }
        }
        Node { range: start..end, content: Content::Table(all) }
    }

    fn scalar(&mut self, e: &Event) -> Node {
        let mut text = Cow::Borrowed("");
        let kind = self.source.get(e).map(|raw| raw.decode_scalar(&mut text, &mut self.errors));
        let digits = || text.replace('_', "");
        let content = match kind {
            Some(ScalarKind::String) => Content::Text(text.into_owned()),
            Some(ScalarKind::Boolean(_)) => Content::Bool,
            Some(ScalarKind::Float) => digits().parse().map_or(Content::Other, Content::Number),
            Some(ScalarKind::Integer(radix)) if radix.value() == 10 => {
                digits().parse().map_or(Content::Other, Content::Number)
            }
            Some(ScalarKind::Integer(radix)) => {
                let value = |v: f64, c: char| v * f64::from(radix.value()) + f64::from(c.to_digit(16).unwrap_or(0));
                Content::Number(digits().chars().fold(0.0, value))
            }
            _ => Content::Other,
        };
        Node { range: range(e.span()), content }
    }
}

fn range(span: Span) -> Range<usize> {
    span.start()..span.end()
}
