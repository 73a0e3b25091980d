//! Formats findings as text with carets, and as JSON.
//!
//! A finding is one report of `annotate-snippets`: main place, other places, help, and the fix as the edited line. At
//! most [`SHOWN`] are printed, errors first, and a last line counts all. Models built by a program lack a text; their
//! findings have title and help. JSON has all findings; lines and columns start at 1, and columns count characters.

use super::diag::{Diag, Diags, KEPT, Severity};
use super::model::{Model, Span};
use super::part::files::Source;
use super::printable::printable;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use annotate_snippets::{AnnotationKind, Group, Level, Patch, Renderer, Snippet};
use core::ops::Range;
use serde_json::{Value as Json, json};

/// Largest number of printed findings; [`KEPT`] limits those kept for each severity.
pub const SHOWN: usize = 20;
/// Largest text that is shown as a whole; of a longer one only the lines around a finding are \[bytes\].
const WHOLE: usize = 1 << 16;
/// Longest line for which a fix is shown as the edited line, which is printed whole.
const LONG: usize = 400;

/// Returns the whole report for a terminal. Empty without findings.
pub fn text(diags: &Diags, model: &Model, color: bool) -> String {
    if diags.list.is_empty() {
        return String::new();
    }
    let renderer = if color { Renderer::styled() } else { Renderer::plain() };
    // errors are chosen before warnings, and printed in the order of the file
    let mut chosen: Vec<usize> = (0..diags.list.len()).collect();
    chosen.sort_by_key(|&i| (diags.list[i].severity, i));
    chosen.truncate(SHOWN);
    chosen.sort_unstable();
    let mut out = String::new();
    for i in chosen {
        out += &renderer.render(&groups(&diags.list[i], model));
        out += "\n\n";
    }
    let all = [Severity::Error, Severity::Warning, Severity::Note].map(|s| diags.count(s)).iter().sum::<usize>();
    if all > SHOWN && !diags.is_full() {
        out += &["… and ", &(all - SHOWN).to_string(), " more\n"].concat();
    }
    out + &summary(diags) + "\n"
}

/// Counts findings: `2 errors, 1 warning`.
pub fn summary(diags: &Diags) -> String {
    let count = |severity: Severity, word: &str| {
        let n = diags.count(severity);
        (n > 0).then(|| format!("{n} {word}{}", if n == 1 { "" } else { "s" }))
    };
    let parts = [(Severity::Error, "error"), (Severity::Warning, "warning"), (Severity::Note, "note")];
    let parts: Vec<String> = parts.into_iter().filter_map(|(s, w)| count(s, w)).collect();
    if diags.is_full() {
        return format!("more than {KEPT} errors: the search stopped there");
    }
    if parts.is_empty() { "no findings".into() } else { parts.join(", ") }
}

fn groups<'a>(d: &'a Diag, model: &'a Model) -> Vec<Group<'a>> {
    let level = match d.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let mut main = Group::with_title(level.primary_title(printable(&d.title)).id(d.code));
    // one snippet for each file, first the file of the first place
    let mut files: Vec<Source> = Vec::new();
    for source in d.labels.iter().filter(|l| l.0.is_some()).map(|l| model.source(l.0)) {
        if !source.text.is_empty() && !files.iter().any(|f| f.start == source.start) {
            files.push(source);
        }
    }
    let mut kind = AnnotationKind::Primary;
    for file in files {
        let view = view(d, model, file);
        let mut snippet = lines(file, &view);
        for (span, label) in d.labels.iter().filter(|l| model.source(l.0).start == file.start) {
            let Some(range) = clamp(file.to_text_span(*span), file.text) else { continue };
            let a = kind.span(range.start - view.start..range.end - view.start);
            kind = AnnotationKind::Context;
            snippet = snippet.annotation(if label.is_empty() { a } else { a.label(label.as_str()) });
        }
        main = main.element(snippet);
    }
    let patch = d.fix.as_ref().and_then(|f| {
        let file = model.source(f.span);
        Some((file, clamp(file.to_text_span(f.span), file.text)?, f.text.as_str()))
    });
    let patch = patch.filter(|(file, range, _)| line_length(file.text, range.start) <= LONG);
    let Some((file, range, new)) = patch else {
        if let Some(help) = &d.help {
            main = main.element(Level::HELP.message(help.as_str()));
        }
        return alloc::vec![main];
    };
    let help = d.help.as_deref().unwrap_or("change it to");
    let view = view(d, model, file);
    let range = range.start - view.start..range.end - view.start;
    let fix =
        Group::with_title(Level::HELP.secondary_title(help)).element(lines(file, &view).patch(Patch::new(range, new)));
    alloc::vec![main, fix]
}

fn line_length(text: &str, at: usize) -> usize {
    let (before, after) = text.split_at(at);
    before.len() - before.rfind('\n').map_or(0, |i| i + 1) + after.find('\n').unwrap_or(after.len())
}

/// Returns the part of a file for a finding: the whole file, or in a long one the lines from its first to its last
/// place. The renderer splits its input into lines for each finding.
fn view(d: &Diag, model: &Model, file: Source<'_>) -> Range<usize> {
    let text = file.text;
    let spans = d.labels.iter().map(|l| l.0).chain(d.fix.as_ref().map(|f| f.span));
    let spans = spans.filter(|s| model.source(*s).start == file.start);
    let ranges: Vec<Range<usize>> = spans.filter_map(|s| clamp(file.to_text_span(s), text)).collect();
    let (Some(from), Some(to)) = (ranges.iter().map(|r| r.start).min(), ranges.iter().map(|r| r.end).max()) else {
        return 0..text.len();
    };
    if text.len() <= WHOLE {
        return 0..text.len();
    }
    text[..from].rfind('\n').map_or(0, |i| i + 1)..text[to..].find('\n').map_or(text.len(), |i| to + i)
}

fn lines<'a, T: Clone>(file: Source<'a>, view: &Range<usize>) -> Snippet<'a, T> {
    let above = file.text[..view.start].bytes().filter(|&b| b == b'\n').count();
    let snippet = Snippet::source(&file.text[view.clone()]).line_start(above + 1);
    if file.file.is_empty() { snippet } else { snippet.path(printable(file.file)) }
}

/// Converts a span to a range within the text on character borders; `None` for a model without text.
fn clamp(span: Span, text: &str) -> Option<Range<usize>> {
    if !span.is_some() || text.is_empty() {
        return None;
    }
    let snap = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = snap(span.start);
    Some(start..snap(span.end).max(start))
}

/// Returns the line and column of a byte, both from 1; columns count characters.
pub fn line_column(text: &str, at: usize) -> (usize, usize) {
    let at = clamp(Span { start: at, end: at }, text).map_or(0, |r| r.start);
    let before = &text[..at];
    let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    (line, before[start..].chars().count() + 1)
}

/// Returns a list of `{code, severity, title, file, line, column, end_line, end_column, labels, help, fix}`. Findings
/// without a place have `null` for lines and columns.
pub fn json(diags: &Diags, model: &Model) -> Json {
    let place = |span: Span| match clamp(model.source(span).to_text_span(span), model.source(span).text) {
        Some(r) => {
            let text = model.source(span).text;
            let ((line, column), (end_line, end_column)) = (line_column(text, r.start), line_column(text, r.end));
            json!({"line": line, "column": column, "end_line": end_line, "end_column": end_column})
        }
        None => json!({"line": null, "column": null, "end_line": null, "end_column": null}),
    };
    let with = |mut base: Json, more: Json| {
        if let (Json::Object(a), Json::Object(b)) = (&mut base, more) {
            a.extend(b);
        }
        base
    };
    let one = |d: &Diag| {
        let severity = match d.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        };
        let labels: Vec<Json> = d.labels.iter().map(|(s, t)| with(place(*s), json!({"text": t}))).collect();
        let fix = d.fix.as_ref().map(|f| with(place(f.span), json!({"text": f.text})));
        let head = json!({"code": d.code, "severity": severity, "title": d.title, "file": model.source(d.span()).file});
        with(with(head, place(d.span())), json!({"labels": labels, "help": d.help, "fix": fix}))
    };
    Json::Array(diags.list.iter().map(one).collect())
}
