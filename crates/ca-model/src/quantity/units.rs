//! Symbols and prefixes of units, and suggestions for unknown words.

use crate::suggest::nearest;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::{Dim, Unit};

/// Symbol, dimension, decimal exponent.
pub(super) const UNITS: &[(&str, Dim, i32)] = &[
    ("m", Unit::METRE.dim, 0),
    ("g", Unit::KILOGRAM.dim, -3),
    ("s", Unit::SECOND.dim, 0),
    ("Hz", Unit::HERTZ.dim, 0),
    ("N", Unit::NEWTON.dim, 0),
    ("J", Unit::JOULE.dim, 0),
    ("W", Unit::WATT.dim, 0),
    ("%", Unit::NONE.dim, -2),
];

/// Prefixes; the first of an exponent is used for output. `μ` is the Greek letter, `µ` the micro sign.
pub(super) const PREFIXES: &[(&str, i32)] = &[
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

/// Usual words for a unit, with its symbol.
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
    ("joule", "J"),
    ("joules", "J"),
    ("watt", "W"),
    ("watts", "W"),
    ("percent", "%"),
    ("micron", "µm"),
];

/// Parses a symbol, or a prefix and a symbol: `m` is the metre, `mm` the millimetre.
pub(super) fn symbol(word: &str) -> Option<(Dim, i32)> {
    let plain = |w: &str| UNITS.iter().find(|u| u.0 == w).map(|u| (u.1, u.2));
    plain(word).or_else(|| {
        let &(p, ten) = PREFIXES.iter().find(|(p, _)| word.starts_with(p))?;
        let (dim, own) = plain(&word[p.len()..]).filter(|_| !word.ends_with('%'))?;
        Some((dim, own + ten))
    })
}

pub(super) fn near(word: &str) -> Option<String> {
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
    nearest(word, known.iter().map(String::as_str)).map(ToString::to_string)
}
