//! Quantities: `"20 g"`, `"0.2 N s/m"`, `"1e8 N/m^1.5"`.
//!
//! Decides that a string that starts with a digit, a sign or a dot is a quantity and any other is not, so that one
//! look tells a number from the name of a `[param]`. Decides that the number is correctly rounded: the prefixes move
//! the decimal point in the text before it becomes a float, so `"20 g"` is the very `f64` 0.02. The alternative,
//! multiplying by 1e-3, is one bit off for every third number and would make a model's bits depend on how its author
//! likes to write. No units library: three exponents and six symbols are all that mechanics needs here.

use super::suggest;
use crate::kind::{Dim, Unit};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// A number with its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// in SI base units
    pub value: f64,
    /// its dimension; [`Dim::NONE`] where no unit is written
    pub dim: Dim,
    /// whether a unit is written; without one the number is in the model's units
    pub has_unit: bool,
}

/// What is wrong in the text of a quantity, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuantityError {
    /// first byte of the part that is wrong
    pub at: usize,
    /// one past its last byte; equal to `at` where something is missing
    pub end: usize,
    /// what is wrong
    pub message: String,
    /// what could be written there instead
    pub hint: Option<String>,
}

impl core::fmt::Display for QuantityError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.message)?;
        self.hint.as_ref().map_or(Ok(()), |h| write!(f, "; did you mean `{h}`?"))
    }
}
impl core::error::Error for QuantityError {}

/// symbol, dimension, decimal exponent
const UNITS: &[(&str, Dim, i32)] = &[
    ("m", Dim::LENGTH, 0),
    ("g", Dim::MASS, -3),
    ("s", Dim::TIME, 0),
    ("Hz", Dim::FREQUENCY, 0),
    ("N", Dim::FORCE, 0),
    ("%", Dim::NONE, -2),
];

/// The first spelling of an exponent is the one we write. `μ` is the Greek letter, `µ` the micro sign.
const PREFIXES: &[(&str, i32)] = &[
    ("k", 3),
    ("m", -3),
    ("µ", -6),
    ("u", -6),
    ("μ", -6),
    ("n", -9),
    ("p", -12),
    ("c", -2),
    ("M", 6),
    ("G", 9),
    ("T", 12),
];

/// Words people write for a unit, and ours.
const SPELLINGS: &[(&str, &str)] = &[
    ("kilo", "kg"),
    ("gr", "g"),
    ("gram", "g"),
    ("grams", "g"),
    ("meter", "m"),
    ("metre", "m"),
    ("meters", "m"),
    ("metres", "m"),
    ("sec", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("hertz", "Hz"),
    ("newton", "N"),
    ("newtons", "N"),
    ("percent", "%"),
    ("micron", "µm"),
];

/// Whether a string is meant as a quantity: it starts with a digit, a sign or a dot.
pub fn is_quantity(text: &str) -> bool {
    text.trim_start().starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '−' | '.'))
}

/// Reads a number and its unit. A blank, `*` or `·` multiplies, `/` divides by the next factor only, `^` raises to a
/// decimal power (`N/m^1.5`), `²` and `³` are accepted.
///
/// ```
/// use ca_core::{kind::Dim, model::quantity::parse};
/// let q = parse("0.2 N s/m").unwrap();
/// assert_eq!((q.value, q.dim), (0.2, Dim::VISCOSITY));
/// assert_eq!(parse("20 g").unwrap().value, 0.02);
/// assert_eq!(parse("20 gr").unwrap_err().hint.as_deref(), Some("g"));
/// ```
pub fn parse(text: &str) -> Result<Quantity, QuantityError> {
    let mut s = Scan { text, at: 0 };
    s.blanks();
    let number = s.number()?;
    let before = s.at;
    s.blanks();
    let unit = if s.peek().is_some() { s.unit(before)? } else { Parsed { dim: Dim::NONE, ten: 0.0, written: false } };
    let shift = libm::round(unit.ten);
    let mut value = number.shifted(shift as i64);
    if (unit.ten - shift).abs() > 1e-9 {
        value *= libm::pow(10.0, unit.ten - shift);
    }
    if !value.is_finite() {
        return Err(fault(number.start, before, "too large for a number"));
    }
    Ok(Quantity { value, dim: unit.dim, has_unit: unit.written })
}

fn fault(at: usize, end: usize, message: impl Into<String>) -> QuantityError {
    QuantityError { at, end, message: message.into(), hint: None }
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
}

/// The text of a number: mantissa with its sign, decimal exponent.
struct Number<'a> {
    start: usize,
    negative: bool,
    mantissa: &'a str,
    ten: i64,
}

impl Number<'_> {
    /// Its value times 10^`by`, correctly rounded.
    fn shifted(&self, by: i64) -> f64 {
        let sign = if self.negative { "-" } else { "" };
        let ten = self.ten.saturating_add(by);
        format!("{sign}{}e{ten}", self.mantissa).parse().unwrap_or(f64::NAN)
    }
}

struct Parsed {
    dim: Dim,
    ten: f64,
    written: bool,
}

impl<'a> Scan<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }
    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }
    /// Steps over the characters `accept` takes and returns them.
    fn take(&mut self, accept: impl Fn(char) -> bool) -> &'a str {
        let rest = self.rest();
        let taken = &rest[..rest.find(|c| !accept(c)).unwrap_or(rest.len())];
        self.at += taken.len();
        taken
    }
    fn blanks(&mut self) -> bool {
        !self.take(char::is_whitespace).is_empty()
    }
    fn eat(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += c.len_utf8();
        }
        found
    }

    fn number(&mut self) -> Result<Number<'a>, QuantityError> {
        let start = self.at;
        let negative = self.eat('-') || self.eat('−');
        if !negative {
            self.eat('+');
        }
        let from = self.at;
        let whole = self.take(|c| c.is_ascii_digit()).len();
        let mut digits = whole;
        if self.eat('.') {
            digits += self.take(|c| c.is_ascii_digit()).len();
        }
        let mantissa = &self.text[from..self.at];
        if digits == 0 {
            return Err(fault(start, self.at, "a quantity starts with a number"));
        }
        if self.rest().starts_with(',') {
            let mut e = fault(self.at, self.at + 1, "the decimal sign is a dot");
            let comma = self.at;
            self.eat(',');
            let tail = self.take(|c| c.is_ascii_digit());
            e.hint = Some(format!("{}.{tail}", &self.text[start..comma]));
            return Err(e);
        }
        Ok(Number { start, negative, mantissa, ten: self.exponent() })
    }

    /// The decimal exponent, or 0 where no digits follow the `e`, which then belongs to a unit.
    fn exponent(&mut self) -> i64 {
        let back = self.at;
        if self.eat('e') || self.eat('E') {
            let negative = self.eat('-') || self.eat('−');
            if !negative {
                self.eat('+');
            }
            let digits = self.take(|c| c.is_ascii_digit());
            if !digits.is_empty() {
                let size = digits.parse::<i64>().unwrap_or(i64::MAX / 2).min(1_000_000);
                return if negative { -size } else { size };
            }
        }
        self.at = back;
        0
    }

    fn unit(&mut self, before: usize) -> Result<Parsed, QuantityError> {
        let mut sum = Parsed { dim: Dim::NONE, ten: 0.0, written: true };
        let mut sign = if self.eat('/') { -1.0 } else { 1.0 };
        loop {
            self.blanks();
            let (dim, ten) = self.factor(before)?;
            let power = sign * self.power()?;
            sum.dim.m += dim.m * power;
            sum.dim.kg += dim.kg * power;
            sum.dim.s += dim.s * power;
            sum.ten += f64::from(ten) * power;
            let blank = self.blanks();
            let at = self.at;
            sign = match self.peek() {
                None => return Ok(sum),
                Some('/') => -1.0,
                Some('*' | '·' | '⋅') => 1.0,
                Some(_) if blank => {
                    sign = 1.0;
                    continue;
                }
                Some(c) => {
                    return Err(fault(at, at + c.len_utf8(), format!("`{c}` is not part of a unit")));
                }
            };
            self.take_one();
        }
    }

    fn take_one(&mut self) {
        self.at += self.peek().map_or(0, char::len_utf8);
    }

    fn factor(&mut self, before: usize) -> Result<(Dim, i32), QuantityError> {
        let start = self.at;
        let word = self.take(|c| c.is_alphabetic() || c == '%' || c == '_');
        if word.is_empty() {
            let end = start + self.peek().map_or(0, char::len_utf8);
            let what =
                if end > start { &self.text[start..end] } else { return Err(fault(start, end, "a unit is missing")) };
            let number_goes_on = start == before && what.starts_with('.');
            let why = if number_goes_on { "is one dot too many" } else { "is not a unit" };
            return Err(fault(start, end, format!("`{what}` {why}")));
        }
        symbol(word).ok_or_else(|| QuantityError {
            at: start,
            end: self.at,
            message: format!("unknown unit: `{word}`"),
            hint: near(word),
        })
    }

    /// The power after a symbol; 1 if none is written.
    fn power(&mut self) -> Result<f64, QuantityError> {
        for (c, power) in [('²', 2.0), ('³', 3.0)] {
            if self.eat(c) {
                return Ok(power);
            }
        }
        if !self.eat('^') {
            return Ok(1.0);
        }
        let start = self.at;
        let text = self.take(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+'));
        match text.parse::<f64>() {
            Ok(p) if p.abs() <= 9.0 => Ok(p),
            Ok(_) => Err(fault(start, self.at, "a power of a unit lies within -9 and 9")),
            Err(_) => Err(fault(start, self.at, "`^` is followed by a number, as in `m^1.5`")),
        }
    }
}

/// A symbol as it stands first, then a prefix and a symbol: `m` is the metre, `mm` the millimetre.
fn symbol(word: &str) -> Option<(Dim, i32)> {
    let plain = |w: &str| UNITS.iter().find(|u| u.0 == w).map(|u| (u.1, u.2));
    plain(word).or_else(|| {
        let &(p, ten) = PREFIXES.iter().find(|(p, _)| word.starts_with(p))?;
        let (dim, own) = plain(&word[p.len()..]).filter(|_| !word.ends_with('%'))?;
        Some((dim, own + ten))
    })
}

/// The unit probably meant by `word`.
fn near(word: &str) -> Option<String> {
    if let Some((_, ours)) = SPELLINGS.iter().find(|(theirs, _)| theirs.eq_ignore_ascii_case(word)) {
        return Some((*ours).into());
    }
    let joined = |(i, _): (usize, char)| {
        let (a, b) = word.split_at(i);
        (i > 0 && symbol(a).is_some() && symbol(b).is_some()).then(|| format!("{a} {b}"))
    };
    if let Some(two) = word.char_indices().find_map(joined) {
        return Some(two);
    }
    let known: Vec<String> = core::iter::once("")
        .chain(PREFIXES.iter().map(|p| p.0))
        .flat_map(|p| UNITS.iter().filter(|u| u.0 != "%").map(move |u| format!("{p}{}", u.0)))
        .collect();
    suggest::nearest(word, known.iter().map(String::as_str)).map(ToString::to_string)
}

/// The shortest text for `value` (in SI) in `unit`, with a prefix where that is shorter: 0.02 kg is `20 g`, 8000 N/m is
/// `8 kN/m`. [`parse`] gives the identical bits back. What is not finite has no such text and is written `inf`, `nan`.
pub fn show(value: f64, unit: Unit) -> String {
    if !value.is_finite() {
        return value.to_string();
    }
    // shortest digits that read back: d.ddd e x
    let text = format!("{:e}", value.abs());
    let (mantissa, ten) = text.split_once('e').unwrap_or((&text, "0"));
    let ten: i32 = ten.parse().unwrap_or(0);
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let sign = if value.is_sign_negative() { "-" } else { "" };
    let gap = if unit.symbol.is_empty() { "" } else { " " };

    let (stem, own) = unit.symbol.strip_prefix('k').map_or((unit.symbol, 0), |rest| (rest, 3));
    let mut best =
        format!("{sign}{mantissa}{}{gap}{}", if ten == 0 { String::new() } else { format!("e{ten}") }, unit.symbol);
    let mut rank = (best.chars().count() + 2, true);
    for &(prefix, p) in [("", 0)].iter().chain(PREFIXES.iter().filter(|p| usual(stem, p.1))) {
        if unit.symbol.is_empty() && p != 0 {
            continue;
        }
        let point = ten + own - p;
        if point.abs() > 18 {
            continue;
        }
        let candidate = format!("{sign}{}{gap}{prefix}{stem}", decimal(&digits, point));
        let this = (candidate.chars().count(), !(0..3).contains(&point));
        if this < rank {
            (best, rank) = (candidate, this);
        }
    }
    best
}

/// Whether people write this prefix before this unit: no kiloseconds, no millihertz, no tonnes as megagrams.
fn usual(stem: &str, ten: i32) -> bool {
    match (stem.split([' ', '/', '^']).next(), ten) {
        (_, -2) => false,
        (Some("Hz"), _) => ten > 0,
        (Some("m" | "s"), _) => ten < 0,
        (Some("g"), _) => ten < 6,
        _ => true,
    }
}

/// Digits d.ddd · 10^`point` without an exponent.
fn decimal(digits: &str, point: i32) -> String {
    let n = digits.len() as i32;
    if point < 0 {
        format!("0.{}{digits}", "0".repeat((-point - 1) as usize))
    } else if n <= point + 1 {
        format!("{digits}{}", "0".repeat((point + 1 - n) as usize))
    } else {
        let (a, b) = digits.split_at(point as usize + 1);
        format!("{a}.{b}")
    }
}

/// A unit of dimension `dim` as authors read it, e.g. `N/m`; empty for a plain number.
pub fn unit_of(dim: Dim) -> String {
    const NAMED: &[Unit] = &[
        Unit::NONE,
        Unit::METRE,
        Unit::KILOGRAM,
        Unit::SECOND,
        Unit::HERTZ,
        Unit::SPEED,
        Unit::ACCELERATION,
        Unit::NEWTON,
        Unit::STIFFNESS,
        Unit::VISCOSITY,
    ];
    if let Some(u) = NAMED.iter().find(|u| u.dim.same(dim)) {
        return u.symbol.into();
    }
    // a power law, N/m^p
    if (dim.kg - 1.0).abs() < 1e-9 && (dim.s + 2.0).abs() < 1e-9 && dim.m < 1.0 {
        return format!("N/m^{}", libm::round((1.0 - dim.m) * 1e9) / 1e9);
    }
    let base = [("kg", dim.kg), ("m", dim.m), ("s", dim.s)].map(|(symbol, p)| (symbol, libm::round(p * 1e9) / 1e9));
    let written = |&(symbol, p): &(&str, f64)| match p {
        0.0 => None,
        1.0 => Some(symbol.to_string()),
        _ => Some(format!("{symbol}^{p}")),
    };
    base.iter().filter_map(written).collect::<Vec<_>>().join(" ")
}
