//! Files of a model: which text a span points into.
//!
//! The files that a model takes parts from have their offsets behind its text, one after the other. So a span remains
//! two numbers, and a finding may point into several files.

pub use crate::model::SourceFile;
use crate::model::{Model, Span};

/// Text that a span points into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source<'m> {
    /// File name; may be empty for the model itself.
    pub file: &'m str,
    /// Whole text.
    pub text: &'m str,
    /// Offset of its first byte among all spans of the model.
    pub start: usize,
}

impl Source<'_> {
    /// Converts a span of the model to a span of this text.
    #[must_use]
    pub fn to_text_span(self, span: Span) -> Span {
        if !span.is_some() {
            return span;
        }
        let local = |at: usize| at.saturating_sub(self.start).min(self.text.len());
        Span { start: local(span.start), end: local(span.end) }
    }
}

impl Model {
    /// Returns the text that `span` points into; the text of the model for [`Span::NONE`].
    pub fn source(&self, span: Span) -> Source<'_> {
        let other = self.files.iter().rev().find(|f| span.is_some() && f.start <= span.start);
        match other {
            Some(f) => Source { file: &f.name, text: &f.text, start: f.start },
            None => Source { file: &self.file, text: &self.text, start: 0 },
        }
    }
}
