//! Target pitches of parts: in hertz or as notes with octave and cents, or as degrees of a scale.

use super::PitchTarget;
use ca_core::Unit;
use ca_lab::Failure;
use ca_model::{Model, Value, quantity};

/// Seven degrees in an octave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Major, in twelve equal steps.
    Equal,
    /// Major, in ratios of small whole numbers.
    Just,
    /// Major, in pure fifths.
    Pythagorean,
    /// Overtones of the root: 1, 2, 3 …
    Harmonic,
}

/// Lists the parts, or single cells of banks, with their target pitches. Each of `parts` is a text `PART=PITCH`, or with
/// a scale and the pitch of its root, the name of a part. `a4` is the frequency of the note A4 \[Hz\].
///
/// # Errors
/// [`Failure::Usage`] for a text of another form, and where a pitch cannot be read.
pub fn targets(
    model: &Model,
    parts: &[String],
    scale: Option<(Scale, &str)>,
    a4: f64,
) -> Result<Vec<PitchTarget>, Failure> {
    let usage = Failure::Usage;
    let Some((scale, root)) = scale else {
        let target = |text: &String| {
            let (part, to) =
                text.split_once('=').ok_or_else(|| format!("`{text}`: expected PART=PITCH, e.g. `low=A2`"))?;
            Ok(PitchTarget { part: part.trim().to_owned(), cell: None, hz: pitch(to, a4)? })
        };
        return parts.iter().map(target).collect::<Result<_, String>>().map_err(usage);
    };
    let root = pitch(root, a4).map_err(usage)?;
    let mut all = Vec::new();
    for part in parts {
        if part.contains('=') {
            return Err(usage(format!(
                "`{part}`: with `--scale`, the scale sets the pitch; give only the name of the part"
            )));
        }
        let cells = model.items.iter().find(|i| i.name == *part).and_then(|i| i.args.iter().find(|e| e.key == "f"));
        match cells.map(|e| &e.value) {
            Some(Value::List(list)) => {
                all.extend((0..list.len()).map(|k| PitchTarget { part: part.clone(), cell: Some(k), hz: 0.0 }));
            }
            _ => all.push(PitchTarget { part: part.clone(), cell: None, hz: 0.0 }),
        }
    }
    all.iter_mut().enumerate().for_each(|(n, w)| w.hz = root * scale.degree(n));
    Ok(all)
}

/// Parses a pitch and returns its frequency \[Hz\]: `220 Hz`, `220`, `A3`, `C#4`, `Bb2+14.5`.
fn pitch(text: &str, a4: f64) -> Result<f64, String> {
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
    /// All scales, with name and description.
    pub const ALL: [(&'static str, &'static str, Scale); 4] = [
        ("equal", "major, in twelve equal steps", Scale::Equal),
        ("just", "major, in ratios of small whole numbers", Scale::Just),
        ("pythagorean", "major, in pure fifths", Scale::Pythagorean),
        ("harmonic", "the overtones of the root: 1, 2, 3 …", Scale::Harmonic),
    ];

    /// Returns the scale with this name.
    pub fn named(name: &str) -> Option<Scale> {
        Self::ALL.iter().find(|s| s.0 == name).map(|s| s.2)
    }

    /// Ratio of degree `n` of the scale to the root, which is degree 0.
    fn degree(self, n: usize) -> f64 {
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
