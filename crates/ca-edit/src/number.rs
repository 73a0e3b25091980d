//! Quantities in the text. A number keeps the unit of its author, and a note stays a note where possible.

use crate::{Document, Place, Value};
use ca_model::quantity;

/// A number of the text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number {
    /// Value in SI units, or as written if no unit is given.
    pub value: f64,
    /// True if the text gives a unit, or a note.
    pub has_unit: bool,
}

/// Returns the number at a place, or `None` if there is not one.
pub fn read(text: &Document, place: &Place) -> Option<Number> {
    match text.value(place)? {
        Value::Text(t) => {
            if let Some(value) = quantity::note(&t) {
                return Some(Number { value, has_unit: true });
            }
            let q = quantity::parse(&t).ok()?;
            Some(Number { value: q.value, has_unit: q.has_unit })
        }
        Value::Number(v) => {
            let size = sibling_unit(text, place).and_then(|u| size(&u));
            Some(Number { value: v * size.unwrap_or(1.0), has_unit: size.is_some() })
        }
        Value::List(_) => None,
    }
}

/// Writes `value` (SI units) at a place with `digits` digits, or adds it to the table of the place. The number keeps
/// the unit that is already there; otherwise it gets `unit`, an SI symbol, or none if `unit` is empty. Returns the
/// written text without quotes, or `None` if the text lacks this place.
pub fn write(text: &mut Document, place: &Place, value: f64, unit: &str, digits: usize) -> Option<String> {
    let old = text.value(place);
    let rounded = quantity::rounded(value, digits);
    let bare = matches!(old, Some(Value::Number(_)));
    let theirs = match &old {
        Some(Value::Text(t)) if quantity::note(t).is_some() => {
            // `note_of` returns `None` below C-1 and above B12; the value then gets a unit
            if let Some(note) = quantity::note_of(rounded) {
                text.set(place, &Value::Text(note.clone()))?;
                return Some(note);
            }
            None
        }
        Some(Value::Text(t)) => t.trim().split_once(char::is_whitespace).map(|(_, u)| u.trim().to_owned()),
        Some(Value::Number(_)) => sibling_unit(text, place),
        _ => None,
    };
    let theirs = theirs.and_then(|u| size(&u).map(|s| (u, s)));
    let (unit, size) = theirs.unwrap_or_else(|| (unit.to_owned(), 1.0));
    let v = quantity::rounded(value / size, digits);
    let new = if bare || unit.is_empty() { Value::Number(v) } else { Value::Text(format!("{v:?} {unit}")) };
    text.set(place, &new)?;
    Some(match new {
        Value::Text(t) => t,
        _ => format!("{v:?}"),
    })
}

/// Returns the `unit` beside the value of a parameter.
fn sibling_unit(text: &Document, place: &Place) -> Option<String> {
    let mut keys = place.keys.clone();
    *keys.last_mut()? = "unit".into();
    match text.value(&Place { keys, index: None })? {
        Value::Text(unit) => Some(unit),
        _ => None,
    }
}

fn size(unit: &str) -> Option<f64> {
    quantity::parse(&format!("1 {unit}")).ok().map(|q| q.value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(value: &str, v: f64, unit: &str) -> String {
        let mut text = Document::read(&format!("a = {{ {value} }}")).unwrap();
        write(&mut text, &Place::keys(["a", "f"]), v, unit, 8).unwrap();
        text.to_string()
    }

    #[test]
    fn a_number_keeps_its_unit() {
        assert_eq!(written("f = \"2 kHz\"", 440.0, "Hz"), "a = { f = \"0.44 kHz\" }");
        assert_eq!(written("f = 2", 440.0, "Hz"), "a = { f = 440.0 }");
        assert_eq!(written("f = 2, unit = \"mm\"", 0.5, "m"), "a = { f = 500.0, unit = \"mm\" }");
        assert_eq!(written("f = \"A4\"", 220.0, "Hz"), "a = { f = \"A3\" }");
        assert_eq!(written("f = \"A4\"", 221.0, "Hz"), "a = { f = \"A3 +7.851415 c\" }");
        assert_eq!(written("g = 1", 3.0, "N/m"), "a = { g = 1, f = \"3.0 N/m\" }");
        assert_eq!(written("f = 1", 1.0 / 3.0, ""), "a = { f = 0.33333333 }");
    }

    #[test]
    fn a_number_is_read_in_si() {
        let read = |text: &str| {
            super::read(&Document::read(text).unwrap(), &Place::keys(["f"])).map(|n| (n.value, n.has_unit))
        };
        assert_eq!(read("f = \"2 mm\""), Some((2e-3, true)));
        assert_eq!(read("f = 2"), Some((2.0, false)));
        assert_eq!(read("f = 2\nunit = \"mm\""), Some((2e-3, true)));
        assert_eq!(read("f = \"A4\""), Some((440.0, true)));
        assert_eq!(read("f = [1]"), None);
        assert_eq!(read("f = \"pitch\""), None);
    }
}
