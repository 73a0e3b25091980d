//! Formats numbers for messages. `ca-model` formats quantities with their units.

use core::fmt;

/// Number for display: in exponent form below 1e-4 and from 1e7 on, where digits are hard to count. It has as many
/// decimals as the format asks for, else the fewest that read back the same.
#[derive(Clone, Copy, Debug)]
pub struct Plain(pub f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let v = self.0;
        let wide = v != 0.0 && v.is_finite() && !(1e-4..1e7).contains(&v.abs());
        if wide { fmt::LowerExp::fmt(&v, f) } else { fmt::Display::fmt(&v, f) }
    }
}
