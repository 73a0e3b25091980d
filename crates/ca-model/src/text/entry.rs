//! Converts TOML values to [`Entry`] and [`Value`], without regard to sections.
//!
//! Integers become floats, as in all later stages, and `inf` and `nan` pass: the compiler knows the parameter and
//! checks ranges. Dates are refused here, because [`Value`] cannot hold them.

use super::reader::Reader;
use crate::diag::Diag;
use crate::model::{Entry, Span, Value};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

pub(crate) type Key<'i> = Spanned<DeString<'i>>;
pub(crate) type Val<'i> = Spanned<DeValue<'i>>;

/// Returns entries in document order; the map of the parser is sorted by key.
pub(crate) fn ordered<'t, 'i>(table: &'t DeTable<'i>) -> Vec<(&'t Key<'i>, &'t Val<'i>)> {
    let mut list: Vec<_> = table.iter().collect();
    list.sort_by_key(|(k, _)| k.span().start);
    list
}

/// Returns the type of a value in words.
pub(crate) fn article(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

impl Reader<'_, '_> {
    pub(crate) fn entries(&mut self, table: &DeTable) -> Vec<Entry> {
        // exact capacity: there may be a million of these
        let mut all = Vec::with_capacity(table.len());
        all.extend(ordered(table).into_iter().filter_map(|(k, v)| self.entry(k.get_ref().as_ref().into(), k, v)));
        all
    }

    pub(crate) fn entry(&mut self, key: String, k: &Key, v: &Val) -> Option<Entry> {
        let value = self.value(&key, v)?;
        Some(Entry { key, key_span: self.span(k), value, span: self.span(v) })
    }

    /// Returns the value as written, or `None` after a report.
    fn value(&mut self, key: &str, v: &Val) -> Option<Value> {
        let span = self.span(v);
        Some(match v.get_ref() {
            DeValue::String(s) => Value::Text(s.as_ref().into()),
            DeValue::Boolean(b) => Value::Bool(*b),
            DeValue::Integer(i) => self.number(key, integer(i.as_str(), i.radix()), span)?,
            DeValue::Float(f) => self.number(key, float(f.as_str()), span)?,
            DeValue::Array(a) => {
                let member = |r: &mut Self, v: &Val| {
                    let value = r.value(key, v)?;
                    Some(Entry { key: String::new(), key_span: Span::NONE, value, span: r.span(v) })
                };
                let mut all = Vec::with_capacity(a.len());
                all.extend(a.iter().filter_map(|v| member(self, v)));
                Value::List(all)
            }
            DeValue::Table(t) => Value::Table(self.entries(t)),
            DeValue::Datetime(_) => {
                let d = Diag::error("E006", format!("`{key}`: a date is not allowed in a model"));
                self.diags.push(d.at(span, "this is a date").help("put it in quotes if it is a text"));
                return None;
            }
        })
    }

    fn number(&mut self, key: &str, number: Option<f64>, span: Span) -> Option<Value> {
        if number.is_none() {
            self.diags.push(Diag::error("E006", format!("`{key}`: too large for a number")).at(span, "beyond 1.8e308"));
        }
        number.map(Value::Num)
    }
}
fn integer(digits: &str, radix: u32) -> Option<f64> {
    if radix == 10 {
        return float(digits);
    }
    let value = digits.chars().filter_map(|c| c.to_digit(radix)).fold(0.0, |v, d| v * f64::from(radix) + f64::from(d));
    value.is_finite().then_some(value)
}

/// Parses a float; `None` if the digits exceed its range. `inf` and `nan` are checked by the compiler.
fn float(text: &str) -> Option<f64> {
    let value: f64 = text.parse().ok()?;
    (!value.is_infinite() || text.contains("inf")).then_some(value)
}
