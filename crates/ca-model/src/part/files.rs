//! Files: which of the texts of a model a span points into.
//!
//! Decides that the files a model takes parts from have their places behind those of its own text, one after the other, so
//! that a span stays two numbers and a finding may point into several files.

pub use crate::model::SourceFile;
use crate::model::{Model, Span};

/// The text a span points into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source<'m> {
    /// name of its file; that of the model may be empty
    pub file: &'m str,
    /// all of it
    pub text: &'m str,
    /// the place of its first byte among all spans of the model
    pub start: usize,
}

impl Source<'_> {
    /// The same place within its text alone.
    #[must_use]
    pub fn within(self, span: Span) -> Span {
        if !span.is_some() {
            return span;
        }
        let local = |at: usize| at.saturating_sub(self.start).min(self.text.len());
        Span { start: local(span.start), end: local(span.end) }
    }
}

impl Model {
    /// The text that `span` points into; that of the model itself where it points nowhere.
    pub fn source(&self, span: Span) -> Source<'_> {
        let other = self.files.iter().rev().find(|f| span.is_some() && f.start <= span.start);
        match other {
            Some(f) => Source { file: &f.name, text: &f.text, start: f.start },
            None => Source { file: &self.file, text: &self.text, start: 0 },
        }
    }
}
