//! A `[param]` as it was read: its number as written, its limits, and where it is used.

use alloc::string::String;
use ca_core::Unit;
use ca_model::quantity::Quantity;
use ca_model::{Entry, Span};

/// A number as written in `[param]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raw {
    /// in the model's units, whatever the dimension
    Bare(f64),
    /// with its unit
    Quantity(Quantity),
}

impl Raw {
    /// The number, in SI if it has a unit.
    pub fn number(self) -> f64 {
        match self {
            Raw::Bare(v) => v,
            Raw::Quantity(q) => q.value,
        }
    }
}

/// A `[param]`.
#[derive(Clone, Debug)]
pub struct Named {
    /// its name
    pub name: String,
    /// its value; `None` where it could not be read, which has been reported
    pub value: Option<Raw>,
    /// may change while playing
    pub live: bool,
    /// the port that drives it, and where that is at `min` and `max`
    pub port: Option<Entry>,
    pub span_of_port: Option<Entry>,
    /// smallest value while playing
    pub min: Option<Raw>,
    /// largest value while playing
    pub max: Option<Raw>,
    /// one line
    pub doc: String,
    /// where it is declared
    pub span: Span,
    /// where its value stands
    pub value_span: Span,
    /// where it was first used: unit and range of that place
    pub used: Option<(Unit, f64, f64)>,
}

impl Named {
    /// A parameter that exists, but has no value.
    pub fn broken(name: &str, span: Span) -> Named {
        Named {
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
