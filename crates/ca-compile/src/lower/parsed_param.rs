//! A parsed `[param]`: its number as written, its limits, and its use.

use alloc::string::String;
use ca_core::Unit;
use ca_model::quantity::Quantity;
use ca_model::{Entry, Span};

/// A number as written in `[param]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raw {
    /// In the units of the model, of any dimension.
    Bare(f64),
    Quantity(Quantity),
}

impl Raw {
    /// Returns the number, in SI if it has a unit.
    pub fn number(self) -> f64 {
        match self {
            Raw::Bare(v) => v,
            Raw::Quantity(q) => q.value,
        }
    }
}

/// A `[param]`.
#[derive(Clone, Debug)]
pub struct ParsedParam {
    /// Name.
    pub name: String,
    /// Value; `None` if it could not be read, which was reported.
    pub value: Option<Raw>,
    /// True if it may change while playing.
    pub live: bool,
    /// Port that drives it, and the values of the port at `min` and `max`.
    pub port: Option<Entry>,
    pub span_of_port: Option<Entry>,
    /// Smallest value while playing.
    pub min: Option<Raw>,
    /// Largest value while playing.
    pub max: Option<Raw>,
    /// Description in one line.
    pub doc: String,
    /// Place of the declaration.
    pub span: Span,
    /// Place of the value.
    pub value_span: Span,
    /// Unit at its first place of use, and the range that all such places allow; `None` if unused.
    pub used: Option<(Unit, f64, f64)>,
}

impl ParsedParam {
    /// Creates a parameter that exists without a value.
    pub fn broken(name: &str, span: Span) -> ParsedParam {
        ParsedParam {
            name: name.into(),
            value: None,
            live: false,
            port: None,
            span_of_port: None,
            min: None,
            max: None,
            doc: String::new(),
            span,
            value_span: span,
            used: None,
        }
    }
}
