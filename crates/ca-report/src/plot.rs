//! Plots as data: axes with units, curves over one grid, marks, an image behind them.
//!
//! Decides that all curves of a plot share their grid, as the library that draws them wants it, and that numbers travel
//! as 32-bit floats: seven digits, which is more than a screen shows, in a third of the room of text. What is not finite
//! is a gap. Axes that are not logarithmic get the prefix of the metric system that keeps their numbers readable.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value as Json, json};

/// Where the points of all curves stand along x.
#[derive(Clone, Debug, PartialEq)]
pub enum Grid {
    /// at equal distances
    Even {
        /// the first
        start: f64,
        /// from one to the next
        step: f64,
        /// how many
        n: usize,
    },
    /// each where it says, rising
    Points(Vec<f64>),
}

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// what is shown
    pub label: String,
    /// its unit; empty for a number
    pub unit: String,
    /// equal distances are equal ratios; what is not above 0 is not shown
    pub log: bool,
    /// what is shown at first, where it is not what there is
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// An axis of equal distances.
    pub fn linear(label: &str, unit: &str) -> Axis {
        Axis { label: label.into(), unit: unit.into(), ..Axis::default() }
    }

    /// An axis of equal ratios.
    pub fn log(label: &str, unit: &str) -> Axis {
        Axis { log: true, ..Axis::linear(label, unit) }
    }

    /// Shows this range at first.
    #[must_use]
    pub fn over(self, from: f64, to: f64) -> Axis {
        Axis { range: Some([from, to]), ..self }
    }

    /// The sound's and everybody's: seconds.
    pub fn time() -> Axis {
        Axis::linear("time", "s")
    }
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// from point to point
    Line,
    /// each point by itself
    Points,
    /// each point by itself, and a line through them
    Both,
    /// a column up to each point
    Bars,
}

/// A curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// its name
    pub name: String,
    /// a value for each point of the grid
    pub y: Vec<f64>,
    /// how it is drawn
    pub look: Look,
}

impl Curve {
    /// A line.
    pub fn line(name: &str, y: Vec<f64>) -> Curve {
        Curve { name: name.into(), y, look: Look::Line }
    }

    /// Least, greatest and last value that there is.
    fn extent(&self) -> Option<[f64; 3]> {
        let some = || self.y.iter().copied().filter(|v| v.is_finite());
        let last = some().next_back()?;
        Some([some().fold(last, f64::min), some().fold(last, f64::max), last])
    }
}

/// A word beside a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// where along x
    pub x: f64,
    /// beside a point at this height; along the whole height where `None`
    pub y: Option<f64>,
    /// the word
    pub text: String,
}

/// A picture behind the curves, as large as the ranges of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// a PNG
    pub png: Vec<u8>,
    /// what its colours mean: words for the first and the last, and the colours between as `#rrggbb`
    pub key: (String, String, Vec<String>),
}

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// what it shows
    pub title: String,
    /// along
    pub x: Axis,
    /// up
    pub y: Axis,
    /// where the points stand
    pub grid: Grid,
    /// the curves
    pub curves: Vec<Curve>,
    /// words
    pub marks: Vec<Mark>,
    /// behind them
    pub image: Option<Image>,
}

/// A point with a name, for [`Plot::scatter`].
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// its name
    pub name: String,
    /// along
    pub x: f64,
    /// up
    pub y: f64,
    /// one of those to look at, joined by a line
    pub front: bool,
}

/// What a curve is called, and its least, greatest and last value, if it has any.
type Extent = (String, Option<[f64; 3]>);

/// Prefixes of the metric system: factor and letter.
const PREFIXES: [(f64, &str); 9] =
    [(1e-15, "f"), (1e-12, "p"), (1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"), (1e9, "G")];

/// Units that take them; seconds and decibels stay as they are.
const METRIC: [&str; 5] = ["m", "N", "J", "W", "Hz"];

/// The prefix for an axis of `unit` with values up to `most`.
fn prefix(unit: &str, most: f64) -> (f64, &'static str) {
    let fits = PREFIXES.iter().rev().find(|p| most >= p.0);
    match fits {
        Some(p) if METRIC.contains(&unit) => *p,
        _ => (1.0, ""),
    }
}

/// Numbers as the script reads them: 32-bit floats, least byte first.
fn packed(values: impl Iterator<Item = f64>) -> String {
    STANDARD.encode(values.flat_map(|v| (v as f32).to_le_bytes()).collect::<Vec<u8>>())
}

impl Plot {
    /// A plot of curves over time \[s\].
    pub fn over_time(title: &str, y: Axis, grid: Grid, curves: Vec<Curve>) -> Plot {
        Plot { title: title.into(), x: Axis::time(), y, grid, curves, marks: Vec::new(), image: None }
    }

    /// Points with names; those of the front are joined, and have a curve of their own.
    pub fn scatter(title: &str, x: Axis, y: Axis, front: &str, others: &str, points: &[Point]) -> Plot {
        let mut points: Vec<&Point> = points.iter().filter(|p| p.x.is_finite() && p.y.is_finite()).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let x = match (points.first(), points.last()) {
            // room for points and words at the edges
            (Some(a), Some(b)) if x.log && x.range.is_none() && a.x > 0.0 => {
                let room = (b.x / a.x).powf(0.04).max(1.05);
                x.over(a.x / room, b.x * room)
            }
            _ => x,
        };
        let of = |front: bool| points.iter().map(|p| if p.front == front { p.y } else { f64::NAN }).collect();
        Plot {
            title: title.into(),
            x,
            y,
            grid: Grid::Points(points.iter().map(|p| p.x).collect()),
            curves: vec![
                Curve { name: others.into(), y: of(false), look: Look::Points },
                Curve { name: front.into(), y: of(true), look: Look::Both },
            ],
            marks: points.iter().map(|p| Mark { x: p.x, y: Some(p.y), text: p.name.clone() }).collect(),
            image: None,
        }
    }

    /// Whether there is anything to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.image.is_none() && self.curves.iter().all(|c| c.extent().is_none())
    }

    /// Factor and unit of the axis up.
    fn scale(&self) -> (f64, String) {
        let most = self.curves.iter().filter_map(Curve::extent).map(|e| e[1].max(-e[0])).fold(0.0, f64::max);
        let (factor, letter) = if self.y.log { (1.0, "") } else { prefix(&self.y.unit, most) };
        (factor, format!("{letter}{}", self.y.unit))
    }

    /// For those who cannot see it: each curve with its least, greatest and last value, in the unit that is shown.
    pub(crate) fn ranges(&self) -> (String, Vec<Extent>) {
        let (factor, unit) = self.scale();
        let row = |c: &Curve| (c.name.clone(), c.extent().map(|e| e.map(|v| v / factor)));
        (unit, self.curves.iter().map(row).collect())
    }

    /// What the script draws.
    pub(crate) fn json(&self, id: &str) -> Json {
        let (factor, unit) = self.scale();
        let axis = |a: &Axis, unit: &str, factor: f64| json!({"label": a.label, "unit": unit, "log": a.log, "range": a.range.map(|r| r.map(|v| v / factor))});
        let grid = match &self.grid {
            Grid::Even { start, step, n } => json!([start, step, n]),
            Grid::Points(x) => json!(packed(x.iter().copied())),
        };
        let curve = |c: &Curve| {
            let look = match c.look {
                Look::Line => "line",
                Look::Points => "points",
                Look::Both => "both",
                Look::Bars => "bars",
            };
            json!({"name": c.name, "look": look, "y": packed(c.y.iter().map(|v| v / factor))})
        };
        let mark = |m: &Mark| json!([m.x, m.y.map(|y| y / factor), m.text]);
        json!({
            "id": id, "x": axis(&self.x, &self.x.unit, 1.0), "y": axis(&self.y, &unit, factor), "grid": grid,
            "curves": self.curves.iter().map(curve).collect::<Vec<_>>(),
            "marks": self.marks.iter().map(mark).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &Json) -> Vec<f32> {
        let bytes = STANDARD.decode(text.as_str().unwrap()).unwrap();
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    }

    #[test]
    fn numbers_get_a_prefix_and_stay_what_they_are() {
        let y = vec![0.0, -1.25e-4, f64::NAN, 1e-5];
        let grid = Grid::Even { start: 0.0, step: 0.5, n: 4 };
        let plot =
            |unit: &str| Plot::over_time("t", Axis::linear("a", unit), grid.clone(), vec![Curve::line("c", y.clone())]);
        let j = plot("m").json("p");
        assert_eq!((&j["y"]["unit"], &j["grid"]), (&json!("µm"), &json!([0.0, 0.5, 4])));
        let read = read(&j["curves"][0]["y"]);
        assert_eq!((read[0], read[1], read[3]), (0.0, -125.0, 10.0));
        assert!(read[2].is_nan());
        assert_eq!(plot("m").ranges().1[0].1.map(|e| e.map(|v| v as f32)), Some([-125.0, 10.0, 10.0]));
        assert_eq!(plot("dB").json("p")["y"]["unit"], "dB");
        for (most, letter) in [(0.0, ""), (1e-18, ""), (3e-15, "f"), (0.999, "m"), (1.0, ""), (1e5, "k"), (1e15, "G")] {
            assert_eq!(prefix("N", most).1, letter, "{most}");
        }
    }

    #[test]
    fn a_scatter_joins_its_front_only() {
        let p = |name: &str, x, y, front| Point { name: name.into(), x, y, front };
        let points =
            [p("b", 2.0, 1.0, true), p("no", f64::NAN, 1.0, true), p("a", 1.0, 5.0, true), p("c", 1.5, 9.0, false)];
        let plot = Plot::scatter("t", Axis::log("x", "s"), Axis::log("y", ""), "best", "rest", &points);
        assert_eq!(plot.grid, Grid::Points(vec![1.0, 1.5, 2.0]));
        assert!(plot.x.range.is_some_and(|[from, to]| from < 1.0 && to > 2.0), "{:?}", plot.x.range);
        let finite = |c: &Curve| c.y.iter().map(|v| v.is_finite()).collect::<Vec<_>>();
        assert_eq!(finite(&plot.curves[0]), [false, true, false]);
        assert_eq!(finite(&plot.curves[1]), [true, false, true]);
        let names: Vec<&str> = plot.marks.iter().map(|m| m.text.as_str()).collect();
        assert_eq!(names, ["a", "c", "b"]);
    }
}
