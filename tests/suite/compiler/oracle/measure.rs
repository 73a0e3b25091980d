//! Measures links in space.

use super::network::{Link, Mat, MeasureKind, Past};

/// Sums in order, as written.
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn difference(b: [f64; 3], a: [f64; 3]) -> [f64; 3] {
    [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
}

fn length(v: [f64; 3], soft: f64) -> f64 {
    (dot(v, v) + soft).sqrt()
}

/// Measured at a port: elongation, its change, the vector from the first end to the second, and its length.
pub struct Measurement {
    pub e: f64,
    pub w: f64,
    v: [f64; 3],
    l: f64,
}

impl Measurement {
    /// Force on the first end along each axis.
    pub fn pull(&self, force: f64) -> [f64; 3] {
        let part = if self.l == 0.0 { 0.0 } else { force / self.l };
        self.v.map(|v| v * part)
    }
}

impl MeasureKind {
    /// Measures between two ends, from positions and motion, and keeps a distance for the next tick.
    pub fn measure(&mut self, a: &Mat, b: &Mat) -> Measurement {
        let (x, d) = (difference(b.x, a.x), difference(b.d, a.d));
        match self {
            MeasureKind::Line([i, j]) => {
                Measurement { e: b.x[*j] - a.x[*i], w: b.d[*j] - a.d[*i], v: [1.0; 3], l: 1.0 }
            }
            MeasureKind::Along(n) => Measurement { e: dot(*n, x), w: dot(*n, d), v: *n, l: 1.0 },
            MeasureKind::Radial(rest, soft, past) => {
                let now = [0, 1, 2].map(|k| rest[k] + x[k]);
                let before = difference(now, d);
                let l = length(now, *soft);
                let w = match past {
                    Past::Motion => {
                        let both = [0, 1, 2].map(|k| now[k] + before[k]);
                        dot(both, d) / (l + length(before, *soft)).max(f64::MIN_POSITIVE)
                    }
                    Past::Stored(last) => l - last.replace(l).unwrap_or_else(|| length(before, *soft)),
                };
                Measurement { e: l, w, v: now, l }
            }
        }
    }

    /// Axes of both ends that it acts along.
    pub fn axes(&self) -> Vec<[usize; 2]> {
        if let MeasureKind::Line(of) = self { vec![*of] } else { vec![[0, 0], [1, 1], [2, 2]] }
    }
}

impl Link {
    pub fn measure(&mut self, mats: &[Mat]) -> Vec<Measurement> {
        self.ports.iter_mut().map(|([a, b], measure)| measure.measure(&mats[*a], &mats[*b])).collect()
    }

    /// Discards kept distances.
    pub fn forget(&mut self) {
        for (_, measure) in &mut self.ports {
            if let MeasureKind::Radial(_, _, Past::Stored(last)) = measure {
                *last = None;
            }
        }
    }
}
