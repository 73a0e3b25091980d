//! Text → lines of `@label type args…`, each token with its place.
//!
//! Decides on blanks as the only separator and `#` as the start of a comment, as the tools of the older dialect do
//! (the younger one also splits at `+`, which would cut `1e+3`). Signs of the younger dialect that show in the form of
//! a line (`~begin`, `[…]`, quotes) are refused here; those that show in a type, in [`super::types`].

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};

/// A word and where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub text: &'a str,
    pub span: Span,
}

/// One module or parameter as written.
#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    /// without its `@`
    pub label: Token<'a>,
    pub ty: Token<'a>,
    pub args: Vec<Token<'a>>,
    /// counted from 1
    pub number: usize,
}

/// The lines of `text`, or `None` where it is not a model of the dialect at all.
pub(super) fn lines<'a>(text: &'a str, diags: &mut Diags) -> Option<Vec<Line<'a>>> {
    let mut lines = Vec::new();
    let mut strange: Option<(Token<'_>, usize)> = None;
    let mut n_strange = 0usize;
    for (number, at, raw) in rows(text) {
        let words = tokens(raw, at);
        let Some((first, rest)) = words.split_first() else { continue };
        if let Some(sign) = younger_form(&words) {
            refuse_younger(number, sign.span, "only in the younger dialect", diags);
            return None;
        }
        if let (Some(label), Some((ty, args))) = (first.text.strip_prefix('@'), rest.split_first()) {
            let span = Span { start: first.span.start + 1, end: first.span.end };
            lines.push(Line { label: Token { text: label, span }, ty: *ty, args: args.to_vec(), number });
        } else {
            n_strange += 1;
            strange.get_or_insert((*first, number));
        }
    }
    if let Some((token, number)) = strange {
        let more = if n_strange > 1 { format!(", and {} more like it", n_strange - 1) } else { String::new() };
        let found = shown(token.text);
        diags.push(
            Diag::error("E030", format!("not a line of a MIMS model: `{found}`, line {number}{more}"))
                .at(token.span, "expected `@label type …`")
                .help("a line is `@label type arguments`; `#` begins a comment"),
        );
        return None;
    }
    if lines.is_empty() {
        diags.push(Diag::error("E030", "not a MIMS model: no line says `@label type …`"));
        return None;
    }
    Some(lines)
}

/// Says once, at the first sign of it, that the younger dialect is not read.
pub(super) fn refuse_younger(number: usize, span: Span, what: &str, diags: &mut Diags) {
    diags.push(
        Diag::error("E028", format!("a model of MIMS4Max, the younger dialect, is not read: line {number}"))
            .at(span, what)
            .help("only `mass M x0 xDelayed` models are read; in the younger dialect the last number is a velocity"),
    );
}

/// At most 40 characters of a word, for a message.
pub(super) fn shown(word: &str) -> String {
    if word.chars().count() <= 40 { word.into() } else { word.chars().take(39).chain(['…']).collect() }
}

fn younger_form<'a>(words: &[Token<'a>]) -> Option<Token<'a>> {
    let first = words.first()?;
    if first.text.starts_with('~') {
        return Some(*first);
    }
    let opens = |w: &&Token<'_>| w.text.starts_with(['[', '\'']);
    if first.text.starts_with('@') { words[1..].iter().find(opens).copied() } else { None }
}

/// Rows with their number and place; they end with a line feed, a carriage return or both.
fn rows(text: &str) -> impl Iterator<Item = (usize, usize, &str)> {
    let mut next = Some(0);
    (1..).map_while(move |number| {
        let at = next?;
        let rest = text.get(at..)?;
        let len = rest.find(['\n', '\r']);
        next = len.map(|len| at + len + if rest[len..].starts_with("\r\n") { 2 } else { 1 });
        Some((number, at, &rest[..len.unwrap_or(rest.len())]))
    })
}

fn tokens(raw: &str, at: usize) -> Vec<Token<'_>> {
    let code = raw.split('#').next().unwrap_or("");
    let blank = |c: char| c.is_whitespace() || c == '\u{feff}';
    let mut words = Vec::new();
    let mut start = None;
    for (i, c) in code.char_indices().chain([(code.len(), ' ')]) {
        match (start, blank(c)) {
            (None, false) => start = Some(i),
            (Some(s), true) => {
                words.push(Token { text: &code[s..i], span: Span { start: at + s, end: at + i } });
                start = None;
            }
            _ => {}
        }
    }
    words
}
