//! Findings about a text with byte ranges, for an editor.

use crate::TextEdit;
use ca_compile::{Options, load};
use ca_core::Catalog;
use ca_core::internal::kind::cloud::Unread;
use ca_model::diag::{Diag, Diags, Severity};
use ca_model::{Model, Span, read};
use core::ops::Range;
use serde::Serialize;

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnostic {
    /// Code, which `ca explain` explains.
    pub code: &'static str,
    /// `error`, `warning` or `note`.
    pub severity: &'static str,
    /// One line that is clear without context.
    pub title: String,
    /// Main place in the text \[bytes\]; `None` without a place in this text.
    pub range: Option<Range<usize>>,
    /// All places in the text, with a few words for each.
    pub labels: Vec<Label>,
    /// Remedy in words.
    pub help: Option<String>,
    /// Remedy as a replacement.
    pub fix: Option<TextEdit>,
    /// Another file that the finding is about; empty for this text.
    pub file: String,
}

/// A place of a finding.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Label {
    /// Bytes of the text.
    pub range: Range<usize>,
    /// A few words; may be empty.
    pub text: String,
}

/// Reads and compiles a text and returns all findings, in the order of the text. `open` returns the text of a file that
/// the model takes parts or points from, by its path from the folder of the model.
pub fn diagnostics(
    text: &str,
    catalog: &Catalog,
    options: &Options,
    open: &mut dyn FnMut(&str) -> Result<String, Unread>,
) -> Vec<Diagnostic> {
    let (model, found) = read::read_with(text, "", catalog, open);
    let found = match load::finish(&model, found, catalog, options) {
        Ok(compiled) => compiled.findings,
        Err(found) => found,
    };
    list(&found, &model)
}

/// Converts findings about a model to ranges of its text.
pub fn list(found: &Diags, model: &Model) -> Vec<Diagnostic> {
    found.list.iter().map(|d| one(d, model)).collect()
}

fn one(d: &Diag, model: &Model) -> Diagnostic {
    let labels: Vec<Label> =
        d.labels.iter().filter_map(|(s, t)| Some(Label { range: range(*s, model)?, text: t.clone() })).collect();
    let fix = d.fix.as_ref().and_then(|f| Some(TextEdit::new(range(f.span, model)?, f.text.clone())));
    Diagnostic {
        code: d.code,
        severity: match d.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        },
        title: d.title.clone(),
        range: range(d.span(), model),
        labels,
        help: d.help.clone(),
        fix,
        file: if model.source(d.span()).start == 0 { String::new() } else { model.source(d.span()).file.into() },
    }
}

/// Returns a span as a range of the model's own text, on character borders.
fn range(span: Span, model: &Model) -> Option<Range<usize>> {
    let source = model.source(span);
    if !span.is_some() || source.start != 0 {
        return None;
    }
    let snap =
        |at: usize| (0..=at.min(source.text.len())).rev().find(|i| source.text.is_char_boundary(*i)).unwrap_or(0);
    let start = snap(span.start);
    Some(start..snap(span.end).max(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_have_ranges_and_fixes() {
        let text = "[MAS]\né = {}\nbob = { mass = \"1 g\" }\n[SOX]\nout = { from = 'bop' }\n[use]\npick = { part = \"plectrum\", with = { on = \"bob\", note = \"H3\" } }\n";
        let mut open = |name: &str| Err(Unread { what: name.into(), help: String::new() });
        let found = diagnostics(text, &ca_model::catalog(), &Options::default(), &mut open);
        let shown: Vec<_> = found.iter().map(|d| (d.code, d.range.clone().map_or("", |r| &text[r]))).collect();
        assert_eq!(shown[..3], [("E014", "é"), ("E004", "mass"), ("E013", "bop")]);
        let fixed = found.iter().filter_map(|d| d.fix.clone()).collect();
        let fixed = crate::Edited::new(text, fixed).text;
        assert!(fixed.contains("{ m = \"1 g\" }") && fixed.contains("'bob'"), "{fixed}");
        let in_part = found.iter().find(|d| d.code == "E026").unwrap();
        assert!(in_part.range.is_some() || in_part.file.starts_with("ca:"), "{in_part:?}");
        assert!(serde_json::to_string(&found).unwrap().contains("\"severity\":\"error\""));
    }
}
