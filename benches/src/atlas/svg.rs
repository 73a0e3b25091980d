//! Draws a map as SVG.
//!
//! A map is only rectangles, lines and a few words, so a drawing library is not needed. Written directly, the file is
//! the same on every machine, small and suited to a diff. Neighbouring cells of one colour are one rectangle.

use super::{Axis, Cell, Field, Map};
use std::fmt::Write as _;

/// Width and height of the map, and its margins: left, top, right, bottom.
pub(crate) const SIZE: [f64; 2] = [560.0, 400.0];
pub(crate) const ROOM: [f64; 4] = [70.0, 16.0, 26.0, 92.0];

/// Colours distinguishable by the colour-blind.
const CALM: &str = "#cfe3f3";
const DIVERGED: &str = "#f0b55a";
const WRONG: &str = "#d00000";

fn colour(cell: &Cell) -> &'static str {
    match (cell.contradicts(), cell.grows) {
        (true, _) => WRONG,
        (_, true) => DIVERGED,
        _ => CALM,
    }
}

/// Returns a step of 1, 2 or 5 times a power of ten that gives at most `most` marks.
fn step(axis: &Axis, most: f64) -> f64 {
    let least = (axis.ends[1] - axis.ends[0]) / most;
    let unit = 10f64.powf(least.log10().floor());
    let round = [1.0, 2.0, 5.0, 10.0].into_iter().find(|r| r * unit >= least * (1.0 - 1e-9)).unwrap_or(10.0) * unit;
    if axis.log { round.max(1.0) } else { round }
}

fn raised(c: char) -> &'static str {
    const DIGITS: [&str; 10] = ["⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
    c.to_digit(10).map_or("⁻", |d| DIGITS[d as usize])
}

/// Returns the marks of an axis: place from 0 to 1, and label.
fn marks(axis: &Axis, most: f64) -> Vec<(f64, String)> {
    let step = step(axis, most);
    let first = (axis.ends[0] / step - 1e-9).ceil() as i32;
    let last = (axis.ends[1] / step + 1e-9).floor() as i32;
    let word = |v: f64| {
        if axis.log {
            return format!("{v:.0}").chars().fold("10".into(), |t: String, c| t + raised(c));
        }
        let text = format!("{v:.3}");
        text.trim_end_matches('0').trim_end_matches('.').to_string()
    };
    let span = axis.ends[1] - axis.ends[0];
    (first..=last).map(|i| f64::from(i) * step).map(|v| ((v - axis.ends[0]) / span, word(v))).collect()
}

/// Begins a picture: size, title, white background, and clipping area.
pub(crate) fn begin(title: &str) -> String {
    let ([w, h], [left, top, right, bottom]) = (SIZE, ROOM);
    let (width, height) = (left + w + right, top + h + bottom);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n<title>{}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <clipPath id=\"map\"><rect x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\"/></clipPath>\n",
        title.replace('"', "&quot;")
    )
}

/// Draws the picture.
pub fn draw(map: &Map, field: &Field) -> String {
    let ([w, h], [left, top, ..]) = (SIZE, ROOM);
    let mut t = begin(map.title) + "<g shape-rendering=\"crispEdges\">\n";
    let up = field.cells.len() / field.across;
    let (dx, dy) = (w / field.across as f64, h / up as f64);
    for (row, cells) in field.cells.chunks(field.across).enumerate() {
        let y = top + h - (row + 1) as f64 * dy;
        let mut first = 0;
        for run in cells.chunk_by(|a, b| colour(a) == colour(b)) {
            let (x, wide, fill) = (left + first as f64 * dx, run.len() as f64 * dx, colour(&run[0]));
            let _ =
                writeln!(t, "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{wide:.2}\" height=\"{dy:.2}\" fill=\"{fill}\"/>");
            first += run.len();
        }
    }
    t += "</g>\n<g clip-path=\"url(#map)\" fill=\"none\" stroke=\"#000\" stroke-width=\"1.6\">\n";
    for line in (map.lines)() {
        let place = |[x, y]: &[f64; 2]| {
            format!("{:.1},{:.1}", left + w * map.axes[0].part(*x), top + h * (1.0 - map.axes[1].part(*y)))
        };
        let points: Vec<String> = line.points.iter().map(place).collect();
        let thin = if line.thin { " stroke-width=\"0.6\" stroke-dasharray=\"5 4\"" } else { "" };
        let _ = writeln!(t, "<polyline points=\"{}\"{thin}/>", points.join(" "));
    }
    t += "</g>\n";
    frame(&mut t, &map.axes);
    legend(&mut t, map, field, [left, top + h + 62.0]);
    t + "</svg>\n"
}

/// Draws the border of a picture, with the marks and names of its axes.
pub(crate) fn frame(t: &mut String, axes: &[Axis; 2]) {
    let ([w, h], [left, top, ..]) = (SIZE, ROOM);
    let _ = writeln!(t, "<rect x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" fill=\"none\" stroke=\"#444\"/>");
    for (part, word) in marks(&axes[0], 10.0) {
        let (x, y) = (left + w * part, top + h);
        let _ = writeln!(t, "<path d=\"M{x:.1} {y:.1}v5\" stroke=\"#444\"/>");
        let _ = writeln!(t, "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{word}</text>", y + 20.0);
    }
    for (part, word) in marks(&axes[1], 8.0) {
        let y = top + h * (1.0 - part);
        let _ = writeln!(t, "<path d=\"M{left} {y:.1}h-5\" stroke=\"#444\"/>");
        let _ = writeln!(t, "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{word}</text>", left - 9.0, y + 4.5);
    }
    let (x, y) = (left + 0.5 * w, top + 0.5 * h);
    let _ = writeln!(t, "<text x=\"{x}\" y=\"{}\" text-anchor=\"middle\">{}</text>", top + h + 42.0, axes[0].name);
    let _ =
        writeln!(t, "<text transform=\"translate(18 {y}) rotate(-90)\" text-anchor=\"middle\">{}</text>", axes[1].name);
}

/// Draws the legend of the colours, and of the line if there is one.
fn legend(t: &mut String, map: &Map, field: &Field, [mut x, y]: [f64; 2]) {
    let wrong = format!("contradicts theory: {}", field.contradictions());
    for (fill, word) in [(CALM, map.words[0]), (DIVERGED, map.words[1]), (WRONG, wrong.as_str())] {
        let _ = writeln!(t, "<rect x=\"{x}\" y=\"{y}\" width=\"14\" height=\"14\" fill=\"{fill}\" stroke=\"#444\"/>");
        let _ = writeln!(t, "<text x=\"{}\" y=\"{}\">{word}</text>", x + 20.0, y + 12.0);
        x += 36.0 + 7.2 * word.chars().count() as f64;
    }
    if !(map.lines)().is_empty() {
        let _ = writeln!(t, "<path d=\"M{x} {}h18\" stroke=\"#000\" stroke-width=\"1.6\"/>", y + 7.0);
        let _ = writeln!(t, "<text x=\"{}\" y=\"{}\">theory</text>", x + 24.0, y + 12.0);
    }
}
