//! Parses a quantity: number, blank, unit. A prefix moves the decimal point before the number becomes a float.

use super::show::unit_of;
use super::units::{near, symbol};
use super::value::{Quantity, QuantityError};
use alloc::format;
use alloc::string::String;
use ca_core::{Dim, Unit};

/// Returns true if a string is meant as a quantity: it starts with a digit, a sign or a dot.
pub fn is_quantity(text: &str) -> bool {
    text.trim_start().starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '−' | '.'))
}

/// Parses a number and its unit. A blank, `*` or `·` multiplies, `/` divides by the next factor only, `^` raises to a
/// decimal power (`N/m^1.5`), and `²` and `³` are accepted.
///
/// ```
/// use ca_core::Unit;
/// use ca_model::quantity::parse;
/// let q = parse("0.2 N s/m").unwrap();
/// assert_eq!((q.value, q.dim), (0.2, Unit::VISCOSITY.dim));
/// assert_eq!(parse("20 g").unwrap().value, 0.02);
/// assert_eq!(parse("20 gr").unwrap_err().hint.as_deref(), Some("g"));
/// ```
///
/// # Errors
/// Fails if the text is not a number with a unit; the error has the wrong characters.
pub fn parse(text: &str) -> Result<Quantity, QuantityError> {
    let mut s = Scan { text, at: 0 };
    s.blanks();
    let number = s.number()?;
    let before = s.at;
    s.blanks();
    let unit =
        if s.peek().is_some() { s.unit(before)? } else { Parsed { dim: Unit::NONE.dim, ten: 0.0, written: false } };
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

/// Splits a number times a name, `"6.27 f"`, into its factors. Returns `None` for a quantity, since units have priority
/// over names: `"4 m"` is four metres even if there is a parameter `m`.
///
/// ```
/// use ca_model::quantity::product;
/// assert_eq!(product("6.27 f"), Some((6.27, "f")));
/// assert_eq!(product("-1e-3 tine[2].f"), Some((-1e-3, "tine[2].f")));
/// assert_eq!(product("4 m"), None);
/// assert_eq!(product("f"), None);
/// ```
pub fn product(text: &str) -> Option<(f64, &str)> {
    let mut s = Scan { text, at: 0 };
    s.blanks();
    let factor = s.number().ok()?.shifted(0);
    let apart = s.blanks();
    let name = s.rest().trim_end();
    let named = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '.' | '[' | ']'));
    (apart && named && factor.is_finite() && parse(text).is_err()).then_some((factor, name))
}

fn fault(at: usize, end: usize, message: impl Into<String>) -> QuantityError {
    QuantityError { at, end, message: message.into(), hint: None }
}

struct Scan<'a> {
    text: &'a str,
    at: usize,
}

/// Number as text: mantissa with its sign, and decimal exponent.
struct Number<'a> {
    start: usize,
    negative: bool,
    mantissa: &'a str,
    ten: i64,
}

impl Number<'_> {
    /// Returns its value times 10^`by`, correctly rounded.
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
    /// Steps over the characters that `accept` takes and returns them.
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

    /// Parses a decimal exponent; 0 if the `e` is not followed by digits and thus belongs to a unit.
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
        let mut sum = Parsed { dim: Unit::NONE.dim, ten: 0.0, written: true };
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

    /// Parses the power after a symbol; 1 if none is written.
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
            Ok(_) => Err(fault(start, self.at, "the power of a unit must be between -9 and 9")),
            Err(_) => Err(fault(start, self.at, "`^` must be followed by a number, as in `m^1.5`")),
        }
    }
}

/// Parses a text as a value of the parameter `name` with this unit \[SI\]. A number without a unit counts in SI.
///
/// # Errors
/// If the text is not a quantity of this unit, in words.
pub fn of_param(name: &str, unit: Unit, text: &str) -> Result<f64, String> {
    let q = parse(text.trim()).map_err(|e| format!("`{name}`: {e}"))?;
    if q.has_unit && !q.dim.same(unit.dim) {
        return Err(format!("`{name}` must be in {}, not in {}", unit.symbol, unit_of(q.dim)));
    }
    Ok(q.value)
}
