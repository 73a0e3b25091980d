//! Notes: `"A4"` is 440 Hz, `"C#3"`, `"Bb2"`, `"A2 +5 c"` with cents.
//!
//! The temperament is equal with A4 at 440 Hz, in scientific pitch notation, where C4 is MIDI note 60. Other
//! temperaments are written as frequencies or cents.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Returns the MIDI number of a note: 60 for `C4`, and for `C4 +5 c`, since keys ignore cents.
pub fn note_number(text: &str) -> Option<u8> {
    u8::try_from(number(parts(text)?.0)?).ok().filter(|n| *n < 128)
}

/// Returns the note nearest to a frequency \[Hz\], with cents if it is off by more than 1e-6: `A4`, `C#4 -13.7 c`.
///
/// Returns `None` outside the named notes, below C-1 or above B12. [`note`] gives the frequency back to 1e-6 cents.
///
/// ```
/// use ca_model::quantity::note_of;
/// assert_eq!(note_of(440.0).as_deref(), Some("A4"));
/// assert_eq!(note_of(441.0).as_deref(), Some("A4 +3.930158 c"));
/// ```
pub fn note_of(f: f64) -> Option<String> {
    let steps = 69.0 + 12.0 * libm::log2(f / 440.0);
    let nearest = libm::round(steps);
    if !(0.0..168.0).contains(&nearest) {
        return None;
    }
    let name = note_name(nearest as u8);
    let cents = libm::round((steps - nearest) * 1e8) / 1e6;
    Some(if cents == 0.0 { name } else { format!("{name} {cents:+} c") })
}

/// Returns the name of a MIDI note, with a sharp if necessary.
///
/// ```
/// use ca_model::quantity::{note_name, note_number};
/// assert_eq!((note_name(60).as_str(), note_name(0).as_str()), ("C4", "C-1"));
/// assert!((0..=127).all(|n| note_number(&note_name(n)) == Some(n)));
/// ```
pub fn note_name(number: u8) -> String {
    const STEPS: [&str; 12] = ["C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"];
    let step = STEPS.get(usize::from(number % 12)).copied().unwrap_or_default();
    format!("{step}{}", i32::from(number / 12) - 1)
}

/// Returns the frequency of a note with optional cents \[Hz\]; `None` if `text` is not a note.
///
/// ```
/// use ca_model::quantity::note;
/// assert_eq!(note("A4"), Some(440.0));
/// assert_eq!(note("A5 +1200 c"), Some(1760.0));
/// assert_eq!(note("bar"), None);
/// ```
pub fn note(text: &str) -> Option<f64> {
    let (name, cents) = parts(text)?;
    let steps = f64::from(number(name)? - 69) + cents / 100.0;
    Some(440.0 * libm::exp2(steps / 12.0))
}

/// Splits a note into its name with octave and its cents.
fn parts(text: &str) -> Option<(&str, f64)> {
    let text = text.trim();
    // a sign after the digits of the octave begins the cents
    let digit = text.find(|c: char| c.is_ascii_digit())?;
    let end = text[digit..].find(|c: char| !c.is_ascii_digit()).map_or(text.len(), |i| digit + i);
    let (name, cents) = text.split_at(end);
    Some((name, if cents.is_empty() { 0.0 } else { cents_of(cents)? }))
}

/// Parses cents: `+5 c`, `-12.5 c`, `+5`.
fn cents_of(text: &str) -> Option<f64> {
    let value = text.trim();
    let value = value.strip_suffix('c').unwrap_or(value).trim_end();
    let signed = value.starts_with(['+', '-', '−']);
    let digits: String = value.replace('−', "-");
    digits.parse().ok().filter(|v: &f64| signed && v.abs() <= 10_000.0)
}

/// Returns the note that `text` probably means: a German name, one without an octave, one in words.
pub fn near_note(text: &str) -> Option<String> {
    let t = text.trim();
    let german = |t: &str| {
        let (name, rest) = t.split_at(t.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(t.len()));
        let name = match name {
            "H" | "h" => "B",
            "Cis" | "cis" => "C#",
            "Dis" | "dis" => "D#",
            "Es" | "es" => "Eb",
            "Fis" | "fis" => "F#",
            "Gis" | "gis" => "G#",
            "As" | "as" => "Ab",
            "Ais" | "ais" => "A#",
            other => other,
        };
        format!("{name}{rest}")
    };
    let all = [t.to_owned(), german(t), format!("{t}4"), format!("{}4", german(t))];
    all.into_iter().find(|c| c.starts_with(|c: char| c.is_ascii_uppercase()) && note(c).is_some())
}

/// Returns the number of semitones above C-1.
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
    let bent = |c: char| match c {
        '#' | '♯' => Some(1),
        'b' | '♭' => Some(-1),
        _ => None,
    };
    // at most two signs: a double sharp or a double flat
    let signs: Vec<char> = rest.chars().take(2).take_while(|c| bent(*c).is_some()).collect();
    let sharp: i32 = signs.iter().filter_map(|c| bent(*c)).sum();
    let octave = rest.get(signs.iter().map(|c| c.len_utf8()).sum()..)?;
    let octave: i32 = octave.parse().ok().filter(|o| (-1..=12).contains(o))?;
    Some(12 * (octave + 1) + step + sharp)
}
