//! Page `docs/instruments.md`: the format of rows and claims, which a test compares with the page.
//!
//! Numbers have few enough digits to be equal on every machine: renders are the same to the bit, transforms are not.

use super::{Claim, Figures, Instrument, one_line};
use std::fmt::Write as _;

/// Text above the table.
pub const HEAD: &str = "# The bundled instruments, measured

After this page you can choose a bundled instrument by its sound, its pitch and its computation time.

Made by `UPDATE=1 cargo bench -p ca-benches --bench instruments`: do not edit.

Each instrument is played by its own gesture, unless its entry in `benches/src/instruments` says otherwise, and measured. A test
measures everything again except the times, and fails if this page differs. Another test plays each instrument that has device
ports with a simulated device, through `ca serve`. `ca render NAME` plays an instrument, `ca list NAME` describes it.

- **pitch**: the strongest partial near the expected pitch, and its deviation from that pitch.
- **centroid**: centre of gravity of the power spectrum of a soft and a loud stroke.
- **T60**: time in which the level falls by 60 dB, extrapolated from its first 12 dB (early) and from the second half of
  its fall (late, over at most 60 dB). One number if both are alike; – if it does not decay.
- **peak**, **DC**: largest sample and largest mean of a channel, in dBFS.
- **end**: largest sample of the last 20 ms, in dBFS; *faded* if `ca render` fades it out, which it does above −60.
- **real time**: seconds of sound per second of computation, by one thread, with the build of the bench, on ";
const COLUMNS: &str = "| instrument | pitch (Hz) | centroid soft / loud (Hz) | T60 early / late (s) | peak | DC | end | real time | \
                       MAT + LIA | picture | sound |\n|---|---|---|---|---|---|---|---|---|---|---|\n";

/// Replaces the hyphen by a minus sign, and removes it from zero.
fn minus(text: &str) -> String {
    let zero = !text.contains(|c: char| ('1'..='9').contains(&c));
    text.replace('-', if zero { "" } else { "−" })
}

fn three(v: f64) -> String {
    if v.fract() == 0.0 || !v.is_finite() {
        return minus(&v.to_string());
    }
    if v.abs() < 1e-3 {
        return minus(&format!("{v:.1e}"));
    }
    let digits = (2 - v.abs().log10().floor() as i32).clamp(0, 6) as usize;
    minus(&format!("{v:.digits$}"))
}

fn level(v: f64) -> String {
    // below the smallest sample of 24 bits
    if v < -150.0 { "none".into() } else { minus(&format!("{v:.1}")) }
}

fn decay(d: [Option<f64>; 2]) -> String {
    let one = |v: Option<f64>| v.map_or("–".into(), |v| minus(&format!("{v:.2}")));
    match d {
        [None, None] => "–".into(),
        [Some(a), Some(b)] if (a / b).ln().abs() < 0.15 => one(Some(b)),
        [a, b] => format!("{} / {}", one(a), one(b)),
    }
}

/// Formats the row of an instrument; `times` is its cell of real time.
pub fn row(i: &Instrument, f: &Figures, times: &str) -> String {
    let name = i.model;
    let pitch = f.pitch.map_or("–".into(), |[hz, off]| format!("{hz:.2}, {} cents", minus(&format!("{off:+.1}"))));
    let [soft, loud] = f.centroid.map(|v| minus(&format!("{v:.0}")));
    let end = format!("{}{}", level(f.end), if f.faded { ", faded" } else { "" });
    format!(
        "| [{name}](../models/{name}.ca.toml) | {pitch} | {soft} / {loud} | {} | {} | {} | {end} | {times} | {} + {} | \
         ![spectrogram](instruments/{name}.png) | [FLAC](instruments/{name}.flac) |\n",
        decay(f.decay),
        level(f.level),
        level(f.dc),
        f.modules[0],
        f.modules[1],
    )
}

fn claim(c: &Claim, figure: f64) -> String {
    let [least, most] = c.range.map(three);
    let keeps = match c.range {
        [a, b] if a == b => format!("must be {least}"),
        [_, b] if b == f64::INFINITY => format!("at least {least}"),
        [a, _] if a == f64::NEG_INFINITY => format!("at most {most}"),
        _ => format!("{least} to {most}"),
    };
    format!("- “{}”: {} ({keeps})\n", one_line(c.sentence), c.shows.replace("{}", &three(figure)))
}

/// Makes the page: `times` returns the cell of real time of an instrument, `machine` describes the machine of the
/// times.
pub fn page(all: &[(&Instrument, Figures)], machine: &str, times: &dyn Fn(&str) -> String) -> String {
    let mut t = format!("{HEAD}{machine}.\n- **MAT + LIA**: modules that are computed.\n\n");
    t += "Pictures are spectrograms of the whole sound: frequency upwards from 40 Hz to half the sound rate on a logarithmic axis,\n\
          90 dB from the loudest to black. Sounds are the loudest channel, some of them only its beginning.\n\n";
    t += COLUMNS;
    for (i, f) in all {
        t += &row(i, f, &times(i.model));
    }
    t += "\n## What the headers say, and what is measured\n\n\
          For each sound: a judgement with its weak points, then quotations from the header of the model, each with the figure that\n\
          supports it and the bounds that a test checks.\n";
    for (i, f) in all {
        let _ = write!(t, "\n### {}\n\n{}\n\n", i.model, one_line(i.remark));
        for (c, figure) in i.claims.iter().zip(&f.claims) {
            t += &claim(c, *figure);
        }
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_three() {
        assert_eq!([1234.6, -0.012_34, 5.0, 0.0, 2.5e-15].map(three), ["1235", "−0.0123", "5", "0", "2.5e−15"]);
    }
}
