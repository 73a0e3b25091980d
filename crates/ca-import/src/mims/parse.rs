//! Splits text into lines of `@label type args…`, each token with its place.
//!
//! Blanks separate words and `#` begins a comment, as in the tools of the older dialect. (The younger one also splits
//! at `+`, which would cut `1e+3`.) This module refuses the younger dialect by the form of a line (`~begin`, `[…]`,
//! quotes); [`super::types`] refuses it by a type.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};

#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub text: &'a str,
    pub span: Span,
}

#[derive(Clone, Debug)]
pub(super) struct Line<'a> {
    /// Without its `@`.
    pub label: Token<'a>,
    pub ty: Token<'a>,
    pub args: Vec<Token<'a>>,
    /// Counted from 1.
    pub number: usize,
}

/// Splits `text` into lines. Returns `None` if it is not a model of this dialect.
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
        let more = if n_strange > 1 { format!(", and {} more such lines", n_strange - 1) } else { String::new() };
        let found = shown(token.text);
        diags.push(
            Diag::error("E030", format!("not a line of a MIMS model: `{found}`, line {number}{more}"))
                .at(token.span, "expected `@label type …`")
                .help("a line is `@label type arguments`; `#` begins a comment"),
        );
        return None;
    }
    if lines.is_empty() {
        let d = Diag::error("E030", "not a MIMS model: no line has the form `@label type …`");
        diags.push(d.at(Span { start: 0, end: 0 }, "begins here"));
        return None;
    }
    Some(lines)
}

/// Reports once that the younger dialect is not read, at its first sign.
pub(super) fn refuse_younger(number: usize, span: Span, what: &str, diags: &mut Diags) {
    diags.push(
        Diag::error("E028", format!("the younger dialect, MIMS4Max, is not supported: line {number}"))
            .at(span, what)
            .help(
                "only `mass M x0 xDelayed` models are supported; in the younger dialect the last number is a velocity",
            ),
    );
}

/// Cuts a word to 40 characters for a message.
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

/// Splits rows, with number and place; they end with a line feed, a carriage return or both.
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
