//! Plots as data: axes with units, curves over one grid, marks, and an image behind them.
//!
//! All curves of a plot share a grid, as the drawing script requires. Numbers are 32-bit floats: their seven digits
//! exceed the resolution of a screen, at a third of the size of text. Non-finite values are gaps. Linear axes get the
//! metric prefix that makes their numbers readable.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value as Json, json};

/// Points of all curves along x.
#[derive(Clone, Debug, PartialEq)]
pub enum Grid {
    /// Evenly spaced points.
    Even {
        /// First point.
        start: f64,
        /// Distance of points.
        step: f64,
        /// Number of points.
        n: usize,
    },
    /// Any points, ascending.
    Points(Vec<f64>),
}

/// Axis of a plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Quantity.
    pub label: String,
    /// Unit; empty for a pure number.
    pub unit: String,
    /// True for a logarithmic axis; values not above 0 are hidden.
    pub log: bool,
    /// Initial range; `None` shows all values.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// Returns a linear axis.
    pub fn linear(label: &str, unit: &str) -> Axis {
        Axis { label: label.into(), unit: unit.into(), ..Axis::default() }
    }

    /// Returns a logarithmic axis.
    pub fn log(label: &str, unit: &str) -> Axis {
        Axis { log: true, ..Axis::linear(label, unit) }
    }

    /// Sets the initial range.
    #[must_use]
    pub fn over(self, from: f64, to: f64) -> Axis {
        Axis { range: Some([from, to]), ..self }
    }

    /// Returns the axis of time \[s\].
    pub fn time() -> Axis {
        Axis::linear("time", "s")
    }
}

/// Style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Line between points.
    Line,
    /// Separate points.
    Points,
    /// Points and a line through them.
    Both,
    /// Bar up to each point.
    Bars,
}

/// Curve of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its name.
    pub name: String,
    /// One value for each point of the grid.
    pub y: Vec<f64>,
    /// Its style.
    pub look: Look,
}

impl Curve {
    /// Returns a curve drawn as a line.
    pub fn line(name: &str, y: Vec<f64>) -> Curve {
        Curve { name: name.into(), y, look: Look::Line }
    }

    fn extent(&self) -> Option<[f64; 3]> {
        let some = || self.y.iter().copied().filter(|v| v.is_finite());
        let last = some().next_back()?;
        Some([some().fold(last, f64::min), some().fold(last, f64::max), last])
    }
}

/// Text at a place of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Place along x.
    pub x: f64,
    /// Height of the point beside it; `None` for the whole height.
    pub y: Option<f64>,
    /// The text.
    pub text: String,
}

/// Picture behind the curves, which fills the ranges of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// PNG file.
    pub png: Vec<u8>,
    /// Colour scale: texts for its ends, and its colours as `#rrggbb`.
    pub key: (String, String, Vec<String>),
}

/// Plot with its title.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Title.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Points along x.
    pub grid: Grid,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Texts.
    pub marks: Vec<Mark>,
    /// Picture behind the curves.
    pub image: Option<Image>,
}

/// Named point for [`Plot::scatter`].
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Its name.
    pub name: String,
    /// Horizontal value.
    pub x: f64,
    /// Vertical value.
    pub y: f64,
    /// True for a point of the front, which is joined by a line.
    pub front: bool,
}

type Extent = (String, Option<[f64; 3]>);

/// Metric prefixes: factor and letter.
const PREFIXES: [(f64, &str); 9] =
    [(1e-15, "f"), (1e-12, "p"), (1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""), (1e3, "k"), (1e6, "M"), (1e9, "G")];

/// Units that take a prefix; seconds and decibels do not.
const METRIC: [&str; 5] = ["m", "N", "J", "W", "Hz"];

/// Returns the prefix for an axis of `unit` with values up to `most`.
fn prefix(unit: &str, most: f64) -> (f64, &'static str) {
    let fits = PREFIXES.iter().rev().find(|p| most >= p.0);
    match fits {
        Some(p) if METRIC.contains(&unit) => *p,
        _ => (1.0, ""),
    }
}

/// Encodes numbers as the script reads them: 32-bit floats, little-endian.
fn packed(values: impl Iterator<Item = f64>) -> String {
    STANDARD.encode(values.flat_map(|v| (v as f32).to_le_bytes()).collect::<Vec<u8>>())
}

impl Plot {
    /// Returns a plot of curves over time \[s\].
    pub fn over_time(title: &str, y: Axis, grid: Grid, curves: Vec<Curve>) -> Plot {
        Plot { title: title.into(), x: Axis::time(), y, grid, curves, marks: Vec::new(), image: None }
    }

    /// Returns a plot of named points. Points of the front are a separate curve and joined by a line.
    pub fn scatter(title: &str, x: Axis, y: Axis, front: &str, others: &str, points: &[Point]) -> Plot {
        let mut points: Vec<&Point> = points.iter().filter(|p| p.x.is_finite() && p.y.is_finite()).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let x = match (points.first(), points.last()) {
            // margin for points and texts at the edges
            (Some(a), Some(b)) if x.log && x.range.is_none() && a.x > 0.0 => {
                let margin = (b.x / a.x).powf(0.04).max(1.05);
                x.over(a.x / margin, b.x * margin)
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

    /// Adds a curve of one of the points of a scatter, which stands out.
    #[must_use]
    pub fn with_chosen(mut self, name: &str, [x, y]: [f64; 2]) -> Plot {
        let is = |m: &Mark| m.x == x && m.y == Some(y);
        let y = self.marks.iter().map(|m| if is(m) { y } else { f64::NAN }).collect();
        self.curves.push(Curve { name: name.into(), y, look: Look::Points });
        self
    }

    /// Returns true if there is nothing to draw.
    pub(crate) fn is_empty(&self) -> bool {
        self.image.is_none() && self.curves.iter().all(|c| c.extent().is_none())
    }

    fn scale(&self) -> (f64, String) {
        let most = self.curves.iter().filter_map(Curve::extent).map(|e| e[1].max(-e[0])).fold(0.0, f64::max);
        let (factor, letter) = if self.y.log { (1.0, "") } else { prefix(&self.y.unit, most) };
        (factor, format!("{letter}{}", self.y.unit))
    }

    /// Returns minimum, maximum and last value of each curve in the displayed unit, as text beside the plot.
    pub(crate) fn ranges(&self) -> (String, Vec<Extent>) {
        let (factor, unit) = self.scale();
        let row = |c: &Curve| (c.name.clone(), c.extent().map(|e| e.map(|v| v / factor)));
        (unit, self.curves.iter().map(row).collect())
    }

    /// Returns the data for the script.
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
        let plot = plot.with_chosen("chosen", [1.5, 9.0]);
        assert_eq!(finite(&plot.curves[2]), [false, true, false]);
    }
}
