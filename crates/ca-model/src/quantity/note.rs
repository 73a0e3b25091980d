//! Notes: `"A4"` is 440 Hz, `"C#3"`, `"Bb2"`, `"A2 +5 c"` with cents.
//!
//! Decides for equal temperament with A4 at 440 Hz, and for scientific pitch notation, in which C4 is note 60 of MIDI. Other
//! temperaments are written as frequencies, or as cents.

use alloc::string::String;

/// Number of a note of MIDI: `C4` is 60.
pub fn note_number(text: &str) -> Option<u8> {
    u8::try_from(number(text)?).ok().filter(|n| *n < 128)
}

/// The frequency of a note with its cents, if any \[Hz\]; `None` where `text` is none.
///
/// ```
/// use ca_model::quantity::note;
/// assert_eq!(note("A4"), Some(440.0));
/// assert_eq!(note("A5 +1200 c"), Some(1760.0));
/// assert_eq!(note("bar"), None);
/// ```
pub fn note(text: &str) -> Option<f64> {
    let text = text.trim();
    let (name, cents) = match text.split_once(char::is_whitespace) {
        Some((name, cents)) => (name, cents_of(cents)?),
        None => (text, 0.0),
    };
    let steps = f64::from(number(name)? - 69) + cents / 100.0;
    Some(440.0 * libm::exp2(steps / 12.0))
}

/// `+5 c`, `-12.5 c`
fn cents_of(text: &str) -> Option<f64> {
    let value = text.trim().strip_suffix('c')?.trim_end();
    let signed = value.starts_with(['+', '-', '−']);
    let digits: String = value.replace('−', "-");
    digits.parse().ok().filter(|v: &f64| signed && v.abs() <= 10_000.0)
}

/// Semitones above C-1.
fn number(text: &str) -> Option<i32> {
    let mut chars = text.chars();
    let step = match chars.next()?.to_ascii_uppercase() {
        'C' => 0,
        'D' => 2,
        'E' => 4,
        'F' => 5,
        'G' => 7,
        'A' => 9,
        'B' => 11,
        _ => return None,
    };
    let rest = chars.as_str();
    let (sharp, octave) = match rest.chars().next()? {
        c @ ('#' | '♯') => (1, &rest[c.len_utf8()..]),
        c @ ('b' | '♭') => (-1, &rest[c.len_utf8()..]),
        _ => (0, rest),
    };
    let octave: i32 = octave.parse().ok().filter(|o| (-1..=12).contains(o))?;
    Some(12 * (octave + 1) + step + sharp)
}
