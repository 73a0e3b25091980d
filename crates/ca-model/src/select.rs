//! Selectors: names of modules, and of members of a generator, in `between`, `from` and gestures.
//!
//! ```text
//! hammer   ball.a              a module; members of a group carry its name
//! low[8]   low[-1]   low[*]    masses of a generator: one, from the end, all
//! low[2..5]   plate[3,4]       a half-open range; row and column of a mesh
//! low.link[3]   low.end[0]     its links, the fixed points at its ends
//! low@0.31  plate@0.3,0.4      a moving point between the ends; the place may be a name: low@place
//! key[3].hammer   key[3].s[8]  the same of an instance of a part; `key[*].hammer` is made a list before ([`super::part`])
//! ```
//! A selector is one string with a small grammar, which is the same in files, on the command line and in Python. Only
//! the text is checked here; the compiler checks names and ranges of indices.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

/// Members of a generator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Masses; also for a plain module.
    Mass,
    /// Links: `.link`.
    Link,
    /// Fixed points at the ends: `.end`.
    End,
}

/// Selected members.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Index {
    /// No brackets.
    None,
    /// `[3]`; negative counts from the end.
    One(i64),
    /// `[3,4]`.
    Two(i64, i64),
    /// `[*]`.
    All,
    /// `[2..5]`, without 5.
    Range(i64, i64),
}

/// Coordinate of a moving point, from 0 to 1 between the ends.
#[derive(Clone, Debug, PartialEq)]
pub enum Coord {
    /// Number.
    Num(f64),
    /// Live parameter or ENX port.
    Name(String),
}

/// Place on a generator: one coordinate on a string, two on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct At(pub Vec<Coord>);

/// Parsed selector.
#[derive(Clone, Debug, PartialEq)]
pub struct Selector {
    /// Full name of the module or generator.
    pub name: String,
    /// Masses, links or ends.
    pub part: Part,
    /// Selected members.
    pub index: Index,
    /// Moving point.
    pub at: Option<At>,
}

/// Error in the text of a selector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelectError {
    /// Byte offset.
    pub at: usize,
    /// Description of the error.
    pub message: String,
}

impl fmt::Display for SelectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}
impl core::error::Error for SelectError {}

fn fault<T>(at: usize, message: impl Into<String>) -> Result<T, SelectError> {
    Err(SelectError { at, message: message.into() })
}

/// Returns true for one word of a name: an ASCII letter or `_`, then letters, digits and `_`.
pub fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_')
}

/// Returns true for a full name: words joined by dots. All but the last may have an index, as in `key[3].hammer`.
pub fn is_name(text: &str) -> bool {
    match text.rsplit_once('.') {
        Some((group, last)) => is_word(last) && is_group(group),
        None => is_word(text),
    }
}

/// Returns true for the full name of a group or an instance: `beads`, `key[3]`, `key[3].room`.
pub fn is_group(text: &str) -> bool {
    let is_index = |t: &str| !t.is_empty() && t.bytes().all(|b| b.is_ascii_digit());
    let instance = |w: &str| match w.split_once('[') {
        Some((word, index)) => is_word(word) && index.strip_suffix(']').is_some_and(is_index),
        None => is_word(w),
    };
    text.split('.').all(instance)
}

/// Parses a selector.
///
/// ```
/// use ca_model::select::{Index, Part, parse};
/// let s = parse("low.link[-1]").unwrap();
/// assert_eq!((s.name.as_str(), s.part, s.index), ("low", Part::Link, Index::One(-1)));
/// assert_eq!(s.to_string(), "low.link[-1]");
/// ```
///
/// # Errors
/// Fails if the text is not a selector; the error has the wrong character.
pub fn parse(text: &str) -> Result<Selector, SelectError> {
    let lead = text.len() - text.trim_start().len();
    let whole = text.trim();
    let (left, place) = match whole.split_once('@') {
        Some((l, r)) => (l, Some((lead + l.len() + 1, r))),
        None => (whole, None),
    };
    let left = left.trim_end();
    // brackets before a dot are indices of instances
    let instances = left.rfind("].").map_or(0, |i| i + 2);
    let (mut name, index) = match left[instances..].split_once('[') {
        Some((word, inner)) => {
            let at = instances + word.len();
            (left[..at].trim_end(), brackets(inner, lead + at + 1)?)
        }
        None => (left, Index::None),
    };
    let mut part = Part::Mass;
    if index != Index::None {
        for (suffix, p) in [(".link", Part::Link), (".end", Part::End)] {
            if let Some(stem) = name.strip_suffix(suffix) {
                (name, part) = (stem, p);
            }
        }
    }
    if !is_name(name) {
        return fault(lead + first_odd(name), odd_name(name));
    }
    let at = match place {
        Some((start, _)) if index != Index::None => {
            return fault(start - 1, "a moving point cannot have an index: write only the place, as in `low@0.31`");
        }
        Some((start, r)) => Some(coords(r, start)?),
        None => None,
    };
    Ok(Selector { name: name.to_owned(), part, index, at })
}

/// Returns the first byte at which `name` stops being a name.
fn first_odd(name: &str) -> usize {
    let mut begin = true;
    for (i, c) in name.char_indices() {
        let fits = if begin { c.is_ascii_alphabetic() } else { c.is_ascii_alphanumeric() };
        if !(fits || c == '_' || c == '.' && !begin) {
            return i;
        }
        begin = c == '.';
    }
    name.len()
}

fn odd_name(name: &str) -> String {
    if name.is_empty() {
        return "a name is missing".into();
    }
    match name[first_odd(name)..].chars().next() {
        Some(']') => "`]` without `[`".into(),
        Some('[') => "brackets before a dot must contain the index of an instance, as in `key[3].hammer`".into(),
        Some(c) if c.is_ascii_digit() => "a name must start with a letter or `_`".into(),
        Some(c) => format!("`{}` is not part of a name", c.escape_debug()),
        None => "a name must not end with a dot".into(),
    }
}

fn brackets(inner: &str, start: usize) -> Result<Index, SelectError> {
    let Some(close) = inner.find(']') else {
        return fault(start + inner.len(), "`]` is missing");
    };
    let after = &inner[close + 1..];
    if !after.is_empty() {
        return fault(start + close + 1, "unexpected text after `]`");
    }
    let inner = &inner[..close];
    let two = |sep: &str| inner.split_once(sep).map(|(a, b)| (a, b, start + a.len() + sep.len()));
    if inner.trim() == "*" {
        Ok(Index::All)
    } else if let Some((a, b, s)) = two("..") {
        Ok(Index::Range(integer(a, start)?, integer(b, s)?))
    } else if let Some((a, b, s)) = two(",") {
        Ok(Index::Two(integer(a, start)?, integer(b, s)?))
    } else {
        Ok(Index::One(integer(inner, start)?))
    }
}

fn integer(text: &str, start: usize) -> Result<i64, SelectError> {
    let at = start + text.len() - text.trim_start().len();
    match text.trim() {
        "" => fault(at, "a number is missing"),
        t => t.parse().or_else(|_| {
            fault(
                at,
                format!("`{}` is not an index: write a whole number, `*` or a range such as `2..5`", t.escape_debug()),
            )
        }),
    }
}

fn coords(text: &str, start: usize) -> Result<At, SelectError> {
    let mut at = start;
    let mut list = Vec::new();
    for piece in text.split(',') {
        let here = at + piece.len() - piece.trim_start().len();
        at += piece.len() + 1;
        let word = piece.trim();
        if list.len() == 2 {
            return fault(here, "a moving point must have one or two coordinates");
        }
        if word.is_empty() {
            return fault(here, "a place is missing after `@`: a number from 0 to 1 or a name");
        }
        let numeric = word.bytes().all(|c| c.is_ascii_digit() || matches!(c, b'.' | b'-' | b'+' | b'e' | b'E'));
        match word.parse::<f64>() {
            _ if is_name(word) => list.push(Coord::Name(word.to_owned())),
            Ok(v) if numeric && v.is_finite() => list.push(Coord::Num(v)),
            _ => return fault(here, format!("`{}` is neither a number nor a name", word.escape_debug())),
        }
    }
    Ok(At(list))
}

impl fmt::Display for Selector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        f.write_str(match self.part {
            Part::Mass => "",
            Part::Link => ".link",
            Part::End => ".end",
        })?;
        match self.index {
            Index::None => {}
            Index::One(i) => write!(f, "[{i}]")?,
            Index::Two(i, j) => write!(f, "[{i},{j}]")?,
            Index::All => f.write_str("[*]")?,
            Index::Range(a, b) => write!(f, "[{a}..{b}]")?,
        }
        for (i, c) in self.at.iter().flat_map(|a| a.0.iter()).enumerate() {
            f.write_str(if i == 0 { "@" } else { "," })?;
            match c {
                Coord::Num(v) => write!(f, "{v}")?,
                Coord::Name(n) => f.write_str(n)?,
            }
        }
        Ok(())
    }
}
