//! Parses pitches in hertz or as notes with octave and cents, and computes scales.

use super::Scale;
use ca_core::Unit;
use ca_model::quantity;

/// Parses a pitch and returns its frequency \[Hz\]: `220 Hz`, `220`, `A3`, `C#4`, `Bb2+14.5`.
pub(super) fn pitch(text: &str, a4: f64) -> Result<f64, String> {
    let text = text.trim();
    let f = quantity::note(text).map(|f| f * (a4 / 440.0)).or_else(|| hertz(text));
    match f {
        Some(f) if f.is_finite() && f > 0.0 => Ok(f),
        _ => Err(format!("`{text}` is not a pitch; write `220 Hz`, `A3`, `C#4` or `Bb2 +14.5 c`")),
    }
}

fn hertz(text: &str) -> Option<f64> {
    let q = quantity::parse(text).ok()?;
    (!q.has_unit || q.dim.same(Unit::HERTZ.dim)).then_some(q.value)
}

impl Scale {
    /// Ratio of degree `n` of the scale to the root, which is degree 0.
    pub(super) fn degree(self, n: usize) -> f64 {
        const EQUAL: [f64; 7] = [0.0, 2.0, 4.0, 5.0, 7.0, 9.0, 11.0];
        const JUST: [f64; 7] = [1.0, 9.0 / 8.0, 5.0 / 4.0, 4.0 / 3.0, 3.0 / 2.0, 5.0 / 3.0, 15.0 / 8.0];
        const FIFTHS: [f64; 7] = [1.0, 9.0 / 8.0, 81.0 / 64.0, 4.0 / 3.0, 3.0 / 2.0, 27.0 / 16.0, 243.0 / 128.0];
        let (octave, step) = ((n / 7) as f64, n % 7);
        match self {
            Scale::Equal => (octave + EQUAL[step] / 12.0).exp2(),
            Scale::Just => octave.exp2() * JUST[step],
            Scale::Pythagorean => octave.exp2() * FIFTHS[step],
            Scale::Harmonic => n as f64 + 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_what_they_are_called() {
        let near = |text: &str, f: f64| assert!((pitch(text, 440.0).expect(text) / f - 1.0).abs() < 1e-12, "{text}");
        near("A4", 440.0);
        near("a3", 220.0);
        near("C4", 440.0 * (-9.0f64 / 12.0).exp2());
        near("Bb2", 440.0 * (-2.0f64 + 1.0 / 12.0).exp2());
        near("C#4+50", 440.0 * (-7.5f64 / 12.0).exp2());
        near("A-1", 440.0 / 32.0);
        near("A-1-100", 440.0 / 32.0 * (-1.0f64 / 12.0).exp2());
        near("220 Hz", 220.0);
        near("1.5 kHz", 1500.0);
        for wrong in ["H4", "A", "4 m", "", "-3", "A4+", "A4x", "é4", "Aé"] {
            assert!(pitch(wrong, 440.0).is_err(), "{wrong}");
        }
        assert!((pitch("A4", 442.0).expect("a pitch") - 442.0).abs() < 1e-12);
    }

    #[test]
    fn scales_rise_and_repeat_by_octaves() {
        for scale in [Scale::Equal, Scale::Just, Scale::Pythagorean, Scale::Harmonic] {
            assert_eq!(scale.degree(0), 1.0);
            assert!((1..30).all(|n| scale.degree(n) > scale.degree(n - 1)));
        }
        assert!((Scale::Just.degree(11) - 3.0).abs() < 1e-15 && (Scale::Equal.degree(7) - 2.0).abs() < 1e-15);
    }
}
