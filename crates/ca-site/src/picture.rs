//! A still picture of an instrument at rest, as SVG.

use ca_view::Drawing;
use serde_json::Value;
use std::fmt::Write as _;

/// Size of the picture, and its margin.
const SIZE: [f64; 2] = [320.0, 180.0];
const MARGIN: f64 = 22.0;

/// Draws the masses and links of a scene, seen from the front and a little from above.
pub fn svg(drawing: &Drawing) -> String {
    let json = drawing.json();
    let rest = numbers(&json["rest"]);
    let up = numbers(&json["up"]);
    let points: Vec<[f64; 2]> = rest.chunks_exact(3).map(|p| project([p[0], p[1], p[2]], &up)).collect();
    let of = |k: usize| points.iter().map(move |p| p[k]).filter(|v| v.is_finite());
    let low = [0, 1].map(|k| of(k).fold(f64::INFINITY, f64::min));
    let high = [0, 1].map(|k| of(k).fold(f64::NEG_INFINITY, f64::max));
    let extent = [high[0] - low[0], high[1] - low[1]];
    let scale =
        [0, 1].map(|k| (SIZE[k] - 2.0 * MARGIN) / extent[k].max(1e-12)).into_iter().fold(f64::INFINITY, f64::min);
    let at = |p: [f64; 2]| [0, 1].map(|k| 0.5 * SIZE[k] + scale * (p[k] - 0.5 * (low[k] + high[k])));
    let places: Vec<[f64; 2]> = points.iter().map(|p| at(*p)).collect();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" aria-hidden=\"true\">",
        SIZE[0], SIZE[1]
    );
    let mut lines = String::new();
    for link in json["links"].as_array().into_iter().flatten() {
        let ends = numbers(&link["ends"]);
        for pair in ends.chunks_exact(2) {
            if let (Some([x, y]), Some([to_x, to_y])) = (places.get(pair[0] as usize), places.get(pair[1] as usize)) {
                let _ = write!(lines, "M{x:.1} {y:.1}L{to_x:.1} {to_y:.1}");
            }
        }
    }
    let _ = write!(out, "<path class=\"links\" d=\"{lines}\"/>");
    let radius = (260.0 / (places.len().max(1) as f64).sqrt()).clamp(1.6, 6.0) * 0.5;
    let fixed = numbers(&json["fixed"]);
    for (p, fixed) in places.iter().zip(&fixed) {
        let class = if *fixed > 0.0 { "fixed" } else { "mass" };
        let _ = write!(out, "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"/>", p[0], p[1]);
    }
    out + "</svg>"
}

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().into_iter().flatten().map(|v| v.as_f64().unwrap_or(0.0)).collect()
}

/// Projects a place along an oblique direction. The picture has its vertical axis downward.
fn project([x, y, z]: [f64; 3], up: &[f64]) -> [f64; 2] {
    // `up` is the second or the third axis
    let (height, depth) = if up.get(2).is_some_and(|u| u.abs() > 0.5) { (z, y) } else { (y, z) };
    [x + 0.35 * depth, -height - 0.25 * depth]
}
