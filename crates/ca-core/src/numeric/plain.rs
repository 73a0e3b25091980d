//! Plain: a number as it stands in what is said to people.
//!
//! Decides only on where an exponent begins; quantities with their units are those of the language.

use core::fmt;

/// A number for people: with an exponent beyond 1e7 and below 1e-4, where digits cannot be counted any more. As many
/// digits behind the point as the format asks for; else the fewest that read back.
#[derive(Clone, Copy, Debug)]
pub struct Plain(pub f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let v = self.0;
        let wide = v != 0.0 && v.is_finite() && !(1e-4..1e7).contains(&v.abs());
        if wide { fmt::LowerExp::fmt(&v, f) } else { fmt::Display::fmt(&v, f) }
    }
}
