//! Texts and fixes for findings about wrong values: the place within the quotes, what was found, and what to write
//! instead.

use alloc::format;
use alloc::string::String;
use ca_core::Unit;
use ca_model::diag::Diag;
use ca_model::quantity::{self, Quantity, QuantityError};
use ca_model::{Entry, Item, Span, Value};

/// Returns the help text for a value outside `min..=max`.
pub fn range_help(min: f64, max: f64, show: impl Fn(f64) -> String) -> String {
    match (min, max) {
        (f64::MIN, f64::MAX) => "use a finite number".into(),
        (f64::MIN_POSITIVE, f64::MAX) => "use a value above 0".into(),
        (_, f64::MAX) => format!("use {} or more", show(min)),
        (f64::MIN, _) => format!("use {} or less", show(max)),
        _ => format!("use a value from {} to {}", show(min), show(max)),
    }
}

/// Returns the span of bytes `from..to` of the text in quotes at `span`. Returns the whole span if quotes or escapes
/// make the byte positions differ from those in the file.
pub fn inside(span: Span, text: &str, from: usize, to: usize) -> Span {
    if !span.is_some() || span.end < span.start || span.end - span.start != text.len() + 2 {
        return span;
    }
    let start = span.start + 1;
    Span { start: start + from.min(text.len()), end: start + to.min(text.len()) }
}

/// Returns the span of the unit in a quantity that was parsed.
pub fn unit_span(e: &Entry, text: &str) -> Span {
    let end = text.trim_end().len();
    let at = text.char_indices().find(|(_, c)| c.is_alphabetic() && !matches!(c, 'e' | 'E') || *c == '%').map(|c| c.0);
    at.map_or(e.span, |at| inside(e.span, text, at, end))
}

/// Returns the error for a text that is not a quantity.
pub fn bad_quantity(what: &str, e: &Entry, text: &str, err: &QuantityError, unit: Option<Unit>) -> Diag {
    // If something is missing, the label points at the character before it.
    let (from, to) = if err.end > err.at { (err.at, err.end) } else { (err.at.saturating_sub(1), err.at.max(1)) };
    let span = inside(e.span, text, from, to);
    let word = text.get(from..to).unwrap_or("");
    let d = Diag::error("E007", format!("{what}: {}", err.message)).at(span, "not a quantity");
    let plain = unit.is_some_and(|u| u.dim.same(Unit::NONE.dim));
    if let (true, "dB", Ok(level)) = (plain, word, text[..from].trim().parse::<f64>()) {
        let factor = libm::round(libm::pow(10.0, level / 20.0) * 1e4) / 1e4;
        return d.help(format!("write a plain factor: {level} dB is {factor}")).fix(e.span, format!("{factor}"));
    }
    let help = match unit {
        Some(_) if plain => "write a plain number, e.g. `1`".into(),
        Some(unit) => format!("write a number and its unit, e.g. `{}`", quoted(unit)),
        None => "write a number and its unit, e.g. `\"8 kN/m\"`".into(),
    };
    let Some(hint) = &err.hint else { return d.help(help) };
    // A comma becomes a dot; a misspelt word becomes the suggestion.
    let new = if word == "," { "." } else { hint.as_str() };
    let mended = [&text[..from], new, &text[to..]].concat();
    match quantity::parse(&mended) {
        Ok(_) if span == e.span => d.help(format!("did you mean `{mended}`?")),
        Ok(_) => d.help(format!("did you mean `{mended}`?")).fix(span, new),
        Err(_) => d.help(help),
    }
}

/// Adds the help, and a fix if there is one, for a quantity of the wrong dimension.
pub fn instead(d: Diag, text: &str, q: &Quantity, unit: Unit, e: &Entry) -> Diag {
    if unit.dim.same(Unit::NONE.dim) {
        let end = text.char_indices().find(|(_, c)| c.is_alphabetic() && !matches!(c, 'e' | 'E'));
        let number = text[..end.map_or(text.len(), |c| c.0)].trim();
        return d.help("write the number without a unit").fix(e.span, number);
    }
    let turned = [(Unit::HERTZ.dim, Unit::SECOND.dim), (Unit::SECOND.dim, Unit::HERTZ.dim)];
    if q.value > 0.0 && turned.iter().any(|(is, wants)| q.dim.same(*is) && unit.dim.same(*wants)) {
        let other = quantity::show(1.0 / q.value, unit);
        if other.len() < 12 {
            return d.help(format!("its reciprocal is {other}; write e.g. `{}`", quoted(unit)));
        }
    }
    d.help(format!("write e.g. `{}`", quoted(unit)))
}

/// Returns a plausible quantity of a unit, for help texts.
pub fn example(unit: Unit) -> String {
    let n = match unit.symbol {
        "m" => "2 mm",
        "kg" => "20 g",
        "s" => "0.5 s",
        "Hz" => "440 Hz",
        "N/m" => "8 kN/m",
        "N s/m" => "0.2 N s/m",
        "m/s" => "0.5 m/s",
        "J" => "10 mJ",
        "" => return "1".into(),
        other => return format!("1 {other}"),
    };
    n.into()
}

/// Returns [`example`] as written in a file: in quotes, unless it is a plain number.
pub fn quoted(unit: Unit) -> String {
    if unit.symbol.is_empty() { example(unit) } else { format!("\"{}\"", example(unit)) }
}

/// Returns the name of a unit within a sentence.
pub fn unit_in_sentence(symbol: &str) -> &str {
    if symbol.is_empty() { "a plain number" } else { symbol }
}

/// Returns the error for a unit of the wrong dimension; `symbol` is the right one.
pub fn wrong_unit(what: &str, symbol: &str, is: &str, span: Span) -> Diag {
    let is = unit_in_sentence(is);
    let title = if symbol.is_empty() {
        format!("{what} must be a plain number, not one in {is}")
    } else {
        format!("{what} must be in {symbol}, not in {is}")
    };
    Diag::error("E008", title).at(span, format!("this is {is}"))
}

/// Returns the type of a value as a phrase for findings.
pub fn type_name(v: &Value) -> &'static str {
    match v {
        Value::Num(_) => "a number",
        Value::Text(_) => "a text",
        Value::Bool(_) => "true or false",
        Value::List(_) => "a list",
        Value::Table(_) => "a table",
    }
}

/// Returns the error for a method that a link cannot use where it is.
pub fn no_method(item: &Item, title: String, label: &str, help: &str) -> Diag {
    let entry = item.args.iter().find(|e| e.key == "method");
    let d = Diag::error("E028", title).at(entry.map_or(item.name_span, |e| e.span), label).help(help);
    if let Some(e) = entry { d.fix(e.span, "\"ca\"") } else { d }
}

/// Rounds down to three digits.
pub fn round_down(v: f64) -> f64 {
    three_digits(v, libm::floor)
}

/// Rounds up to three digits.
pub fn round_up(v: f64) -> f64 {
    three_digits(v, libm::ceil)
}

/// Rounds to three digits. The power of ten is applied as text, so that display adds no further digits.
fn three_digits(v: f64, to: fn(f64) -> f64) -> f64 {
    let ten = libm::floor(libm::log10(v.abs().max(1e-300))) - 2.0;
    let n = to(v / libm::pow(10.0, ten));
    format!("{n}e{ten}").parse().unwrap_or(v)
}
