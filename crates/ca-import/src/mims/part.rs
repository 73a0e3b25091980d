//! Parts: every module with its kind, its arguments and what it holds on to, by index.

use super::names::Names;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Span;

/// An argument of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arg {
    Num(f64),
    /// index into [`Net::params`]
    Param(usize),
    Word(&'static str),
    /// points of a curve
    Curve([[f64; 2]; 4]),
}

impl Arg {
    /// The same argument as an ordered key; numbers by their bits.
    pub fn key(self) -> (u8, u64) {
        match self {
            Arg::Num(x) => (0, x.to_bits()),
            Arg::Param(i) => (1, i as u64),
            Arg::Word(w) => (2, w.len() as u64),
            Arg::Curve(points) => (3, points.iter().flatten().fold(0, |h, x| h.rotate_left(7) ^ x.to_bits())),
        }
    }
}

/// A named parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub name: String,
    pub span: Span,
    pub value: f64,
    /// the first part that took its value as a number
    pub folded: Option<String>,
}

/// A module.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub name: String,
    /// where its label stands
    pub span: Span,
    pub kind: &'static str,
    pub args: Vec<(&'static str, Arg)>,
    /// the parts it holds on to: none, one (port) or two (link)
    pub ends: Vec<usize>,
    /// index into [`Net::groups`]
    pub group: Option<usize>,
    /// rest position of a `posInput`; everything else rests at 0
    pub rest: Arg,
}

impl Part {
    /// The argument `key`, 0 where it is not written.
    pub fn arg(&self, key: &str) -> Arg {
        self.args.iter().find(|a| a.0 == key).map_or(Arg::Num(0.0), |a| a.1)
    }

    /// Puts it at `x` at the start.
    pub fn place(&mut self, x: Arg) {
        if x != Arg::Num(0.0) {
            self.args.push(("dx0", x));
        }
    }
}

/// A model before it is written.
#[derive(Clone, Debug, Default)]
pub(super) struct Net {
    pub params: Vec<Param>,
    /// in document order
    pub parts: Vec<Part>,
    /// name and acceleration [m per sample²] of each group
    pub groups: Vec<(String, f64)>,
    pub names: Names,
}

impl Net {
    /// The number behind an argument; 0 where it is none.
    pub fn value(&self, arg: Arg) -> f64 {
        match arg {
            Arg::Num(x) => x,
            Arg::Param(i) => self.params.get(i).map_or(0.0, |p| p.value),
            Arg::Word(_) | Arg::Curve(_) => 0.0,
        }
    }
}
