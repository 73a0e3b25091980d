//! Spectrogram of a sound, as a picture.
//!
//! The picture is made here: it has a tenth of the size of its numbers and is visible without a script. Rows are spaced
//! by equal ratios, as pitch is heard; rows between bins are interpolated, rows of several bins show the loudest.
//! Windows overlap at least by half, so no moment is left out; a column shows the loudest of its windows.

use crate::plot::{Axis, Curve, Grid, Image, Look, Plot};
use crate::sound::{CHANNELS, Sound};
use crate::spectrum::{Hann, decibel};

/// Longest window \[s\].
const WINDOW: f64 = 0.1;
/// Largest number of columns, and number of rows.
const COLUMNS: usize = 640;
const ROWS: usize = 220;
/// Lowest row \[Hz\].
const LOWEST: f64 = 40.0;
/// Range from the loudest level to black \[dB\].
const DEPTH: f64 = 90.0;
/// Number of colour steps; finer steps are larger and not visible.
const STEPS: usize = 60;
/// Colours from silence to the loudest level. Brightness increases, also for colour-blind readers and in print.
const COLOURS: [[u8; 3]; 6] =
    [[8, 8, 20], [42, 22, 92], [122, 32, 110], [204, 62, 74], [246, 146, 52], [252, 246, 190]];

fn colour(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let i = (at as usize).min(COLOURS.len() - 2);
    let part = at - i as f64;
    std::array::from_fn(|k| {
        let [a, b] = [COLOURS[i][k], COLOURS[i + 1][k]].map(f64::from);
        (a + part * (b - a)).round() as u8
    })
}

/// Returns the power of the row from `low` to `high` \[bins\].
fn row(power: &[f64], low: f64, high: f64) -> f64 {
    let last = power.len() - 1;
    let (first, end) = (low.ceil() as usize, (high.ceil() as usize).min(power.len()));
    if first < end {
        return power[first..end].iter().copied().fold(0.0, f64::max);
    }
    let at = (0.5 * (low + high)).min(last as f64);
    let i = (at as usize).min(last.saturating_sub(1));
    let part = at - i as f64;
    power[i] + part * (power[(i + 1).min(last)] - power[i])
}

/// Returns the spectrogram of the stored sound, with the powers of all channels added; `None` for silence.
pub fn spectrogram(sound: &Sound) -> Option<Plot> {
    let channels: Vec<Vec<f64>> = (0..sound.names().len().min(CHANNELS)).map(|k| sound.channel(k)).collect();
    let n = channels.first().map_or(0, Vec::len);
    let highest = 0.5 * sound.rate();
    if n == 0 || highest <= LOWEST {
        return None;
    }
    let longest = (WINDOW * sound.rate()).max(2.0) as usize;
    let size = (longest + 1).next_power_of_two() / 2;
    let mut hann = Hann::new(size, size);
    let columns = COLUMNS.min(n.div_ceil(size / 16 + 1));
    // windows for each column
    let each = (2 * n).div_ceil(size * columns).max(1);
    let step = sound.rate() / size as f64;
    let edge = |r: usize| LOWEST * (highest / LOWEST).powf(r as f64 / ROWS as f64) / step;
    let mut power = vec![0.0; size / 2 + 1];
    let mut cells = vec![0.0_f64; columns * ROWS];
    for i in 0..columns * each {
        let centre = (i as f64 + 0.5) * n as f64 / (columns * each) as f64;
        power.fill(0.0);
        let start = centre as isize - size as isize / 2;
        for samples in &channels {
            hann.add(samples, start, &mut power);
        }
        for r in 0..ROWS {
            // the top row is the highest frequency
            let cell = &mut cells[(ROWS - 1 - r) * columns + i / each];
            *cell = cell.max(row(&power, edge(r), edge(r + 1)));
        }
    }
    let top = cells.iter().copied().fold(0.0, f64::max);
    if top == 0.0 {
        return None;
    }
    let top = decibel(top);
    let level = |p: &f64| (((decibel(*p) - top) / DEPTH + 1.0).max(0.0) * STEPS as f64) as u8;
    let pixels: Vec<u8> = cells.iter().map(level).collect();
    let colours: Vec<[u8; 3]> = (0..=STEPS).map(|i| colour(i as f64 / STEPS as f64)).collect();
    let hex = |c: &[u8; 3]| format!("#{:02x}{:02x}{:02x}", c[0], c[1], c[2]);
    Some(Plot {
        title: "Spectrogram".into(),
        x: Axis::time(),
        y: Axis::log("frequency", "Hz").over(LOWEST, highest),
        grid: Grid::Points(vec![0.0, sound.held()]),
        curves: vec![Curve { name: "frequency".into(), y: vec![f64::NAN; 2], look: Look::Points }],
        marks: Vec::new(),
        image: Some(Image {
            png: png(columns, &pixels, colours.as_flattened())?,
            key: (format!("{:.0} dBFS", top - DEPTH), format!("{top:.0} dBFS"), COLOURS.iter().map(hex).collect()),
        }),
    })
}

/// Encodes a picture with rows of `width` pixels, as indices into a palette.
fn png(width: usize, pixels: &[u8], palette: &[u8]) -> Option<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, (pixels.len() / width) as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(pixels).ok()?;
    writer.finish().ok()?;
    Some(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the width and the palette indices.
    fn pixels(plot: &Plot) -> (usize, Vec<u8>) {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(&plot.image.as_ref().unwrap().png));
        decoder.set_transformations(png::Transformations::IDENTITY);
        let mut reader = decoder.read_info().unwrap();
        let mut all = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut all).unwrap();
        assert_eq!((info.width as usize * ROWS, info.height as usize), (all.len(), ROWS));
        (info.width as usize, all)
    }

    /// Returns the row of a frequency, from the top.
    fn row_of(f: f64) -> usize {
        ROWS - 1 - ((f / LOWEST).ln() / (24_000.0 / LOWEST).ln() * ROWS as f64) as usize
    }

    /// One second at 300 Hz, then one at 5 kHz in the other channel: each half is brightest in its row.
    #[test]
    fn the_picture_shows_what_sounds_when() {
        let mut s = Sound::new(48_000.0, &["a".into(), "b".into()]);
        for n in 0..96_000 {
            let tone = |f: f64| 0.5 * (std::f64::consts::TAU * f * f64::from(n) / 48_000.0).sin();
            s.push(&if n < 48_000 { [tone(300.0), 0.0] } else { [0.0, tone(5000.0)] });
        }
        let plot = spectrogram(&s).unwrap();
        let (width, indices) = pixels(&plot);
        assert_eq!(width, 96_000_usize.div_ceil(4096 / 16 + 1), "windows overlap by 15 sixteenths where there is room");
        for (column, f) in [(width / 4, 300.0), (3 * width / 4, 5000.0)] {
            let bright = (0..ROWS).max_by_key(|r| indices[r * width + column]).unwrap();
            assert!(bright.abs_diff(row_of(f)) <= 1, "{f} Hz stands in row {bright}, not {}", row_of(f));
            assert!(usize::from(indices[bright * width + column]) >= STEPS - 1);
            assert_eq!(indices[row_of(1300.0) * width + column], 0);
        }
    }

    /// A click of one sample is visible at any time within half a minute.
    #[test]
    fn no_moment_is_left_out() {
        let n = 30 * 48_000;
        for at in [7, n / 3 + 5, n - 9] {
            let mut s = Sound::new(48_000.0, &["a".into()]);
            (0..n).for_each(|i| s.push(&[f64::from(u8::from(i == at))]));
            let (width, all) = pixels(&spectrogram(&s).unwrap());
            let column = at * width / n;
            let bright = (0..width).filter(|c| all[c + 50 * width] > 0).collect::<Vec<_>>();
            assert!(bright.contains(&column) && bright.len() <= 4, "{bright:?}, not {column}");
        }
    }

    #[test]
    fn silence_has_no_picture_and_one_sample_has_one() {
        let mut s = Sound::new(48_000.0, &["a".into()]);
        assert!(spectrogram(&s).is_none());
        s.push(&[0.5]);
        assert_eq!(pixels(&spectrogram(&s).unwrap()).0, 1);
        let mut s = Sound::new(48_000.0, &["a".into()]);
        s.push(&vec![0.0; 4800]);
        assert!(spectrogram(&s).is_none());
    }
}
