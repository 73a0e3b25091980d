//! Formats a number as an author would: the shortest text that reads back to the same bits, with usual prefixes.

use super::units::PREFIXES;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_core::{Dim, Unit};

/// Rounds to six digits, which suffice for a computed number. [`show`] and [`Plain`](super::Plain) write all digits.
pub fn six(value: f64) -> f64 {
    rounded(value, 6)
}

/// Rounds to `digits` digits, at least one.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.0$e}", digits.max(1) - 1).parse().unwrap_or(value)
}

/// Formats a number with three digits, with an exponent if it is large or small.
///
/// ```
/// use ca_model::quantity::short;
/// assert_eq!((short(0.0123456), short(12.3456), short(123_456.0)), ("0.0123".into(), "12.3".into(), "1.23e5".into()));
/// ```
pub fn short(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return value.to_string();
    }
    let digits = 2 - libm::floor(libm::log10(value.abs())) as i32;
    if (0..=4).contains(&digits) { format!("{value:.*}", digits as usize) } else { format!("{value:.2e}") }
}

/// Formats `value` (SI units) in `unit` with the shortest text: 0.02 kg is `20 g`, 8000 N/m is `8 kN/m`.
///
/// [`parse`](super::parse) gives identical bits back. Non-finite values are written `inf` and `nan`.
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

/// Returns true if a prefix is usual with a unit; kiloseconds, millihertz and megagrams are not.
fn usual(stem: &str, ten: i32) -> bool {
    match (stem.split([' ', '/', '^']).next(), ten) {
        (_, -2) => false,
        (Some("Hz"), _) => ten > 0,
        (Some("m" | "s"), _) => ten < 0,
        (Some("g"), _) => ten < 6,
        _ => true,
    }
}

/// Formats d.ddd · 10^`point` without an exponent.
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

/// Returns a unit of dimension `dim`, e.g. `N/m`; empty for a plain number.
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
        Unit::MOMENTUM,
        Unit::COMPLIANCE,
        Unit::JOULE,
        Unit::WATT,
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
