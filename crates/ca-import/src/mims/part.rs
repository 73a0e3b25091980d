//! Parts: each module with its kind, its arguments and its ends by index.

use super::names::Names;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Span;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arg {
    Num(f64),
    /// Index into [`Net::params`].
    Param(usize),
    Word(&'static str),
    Curve([[f64; 2]; 4]),
}

impl Arg {
    /// Returns the argument as an ordered key; numbers by their bits.
    pub fn key(self) -> (u8, u64) {
        match self {
            Arg::Num(x) => (0, x.to_bits()),
            Arg::Param(i) => (1, i as u64),
            Arg::Word(w) => (2, w.len() as u64),
            Arg::Curve(points) => (3, points.iter().flatten().fold(0, |h, x| h.rotate_left(7) ^ x.to_bits())),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Param {
    pub name: String,
    pub span: Span,
    pub value: f64,
    /// First part that took its value as a number.
    pub folded: Option<String>,
}

#[derive(Clone, Debug)]
pub(super) struct Part {
    pub name: String,
    /// Place of its label.
    pub span: Span,
    pub kind: &'static str,
    pub args: Vec<(&'static str, Arg)>,
    /// Ends: none, one (port) or two (link).
    pub ends: Vec<usize>,
    /// Index into [`Net::groups`].
    pub group: Option<usize>,
    /// Rest position of a `posInput`; all other parts rest at 0.
    pub rest: Arg,
}

impl Part {
    /// Returns the argument `key`, 0 if it is not written.
    pub fn arg(&self, key: &str) -> Arg {
        self.args.iter().find(|a| a.0 == key).map_or(Arg::Num(0.0), |a| a.1)
    }

    /// Sets the displacement at the start.
    pub fn place(&mut self, x: Arg) {
        if x != Arg::Num(0.0) {
            self.args.push(("dx0", x));
        }
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Net {
    pub params: Vec<Param>,
    /// Parts in document order.
    pub parts: Vec<Part>,
    /// Name and acceleration [m per sample²] of each group.
    pub groups: Vec<(String, f64)>,
    pub names: Names,
}

impl Net {
    /// Returns the number of an argument, 0 for a word or a curve.
    pub fn value(&self, arg: Arg) -> f64 {
        match arg {
            Arg::Num(x) => x,
            Arg::Param(i) => self.params.get(i).map_or(0.0, |p| p.value),
            Arg::Word(_) | Arg::Curve(_) => 0.0,
        }
    }
}
