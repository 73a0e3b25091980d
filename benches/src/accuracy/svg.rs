//! Draws error against run time as SVG: a line for each method through its multiples of the rate, on logarithmic axes.

use super::Found;
use crate::atlas::Axis;
use crate::atlas::svg::{ROOM, SIZE, begin, frame};
use std::fmt::Write as _;

/// Colour of each method, also for the colour-blind, in order of appearance.
const COLOURS: [(&str, &str); 11] = [
    ("as written", "#000000"),
    ("centred", "#56b4e9"),
    ("implicit 1/12", "#0072b2"),
    ("implicit 1/4", "#5f7fb5"),
    ("implicit 1/2", "#9aa9c4"),
    ("modal", "#009e73"),
    ("pefrl", "#d55e00"),
    ("stable", "#cc79a7"),
    ("secant", "#e69f00"),
    ("newton", "#8c564b"),
    ("single", "#7f7f7f"),
];

/// Names in a row of the legend.
const ACROSS: usize = 5;

/// Returns an axis of whole decades around all values.
fn decades(name: &'static str, all: impl Iterator<Item = f64>) -> Axis {
    let (low, high) =
        all.filter(|v| *v > 0.0 && v.is_finite()).fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    let (low, high) = if low > high { (1.0, 10.0) } else { (low, high) };
    let (from, to) = (low.log10().floor(), high.log10().ceil());
    Axis::log(name, from, if to > from { to } else { from + 1.0 })
}

/// Draws the picture.
pub fn draw(title: &str, found: &Found) -> String {
    let ([w, h], [left, top, ..]) = (SIZE, ROOM);
    let level = |error: f64| error.max(found.known);
    let axes = [
        decades("time of a sample [ns]", found.rows.iter().map(|r| r.ns)),
        decades("error", found.rows.iter().map(|r| level(r.error))),
    ];
    let mut t = begin(title);
    let (mut shown, mut points) = (0, String::new());
    for (method, colour) in COLOURS {
        let rows: Vec<_> = found.rows.iter().filter(|r| r.method == method && r.error.is_finite()).collect();
        if rows.is_empty() {
            continue;
        }
        let at: Vec<[f64; 2]> = rows
            .iter()
            .map(|r| [left + w * axes[0].part(r.ns), top + h * (1.0 - axes[1].part(level(r.error)))])
            .collect();
        let line: Vec<String> = at.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(points, "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\"/>", line.join(" "));
        for (r, [x, y]) in rows.iter().zip(&at) {
            let fill = if r.front { colour } else { "#fff" };
            let _ =
                writeln!(points, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\" stroke=\"{colour}\"/>");
            if r.times > 1 {
                let (x, y) = (x + 6.0, y - 4.0);
                let _ = writeln!(
                    points,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"9\" fill=\"{colour}\">×{}</text>",
                    r.times
                );
            }
        }
        let (x, y) =
            (left + (shown % ACROSS) as f64 * w / ACROSS as f64, top + h + 60.0 + (shown / ACROSS) as f64 * 17.0);
        let _ = writeln!(t, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{colour}\"/>", x + 4.0, y - 4.0);
        let _ = writeln!(t, "<text x=\"{:.1}\" y=\"{y:.1}\">{method}</text>", x + 12.0);
        shown += 1;
    }
    frame(&mut t, &axes);
    t + "<g clip-path=\"url(#map)\">\n" + &points + "</g>\n</svg>\n"
}
