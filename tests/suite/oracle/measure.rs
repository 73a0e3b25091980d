//! What a link in space measures, by the ledger.

use super::network::{Mat, MeasureKind};

/// One after the other, as sums are written.
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn difference(b: [f64; 3], a: [f64; 3]) -> [f64; 3] {
    [b[0] - a[0], b[1] - a[1], b[2] - a[2]]
}

impl MeasureKind {
    /// Elongation, its change, and the forces on the second end of a push of 1, from places and ways of both ends.
    pub fn feel(&self, a: &Mat, b: &Mat) -> (f64, f64, [f64; 3]) {
        let (x, d) = (difference(b.x, a.x), difference(b.d, a.d));
        match *self {
            MeasureKind::Line([i, j]) => (b.x[j] - a.x[i], b.d[j] - a.d[i], [1.0; 3]),
            MeasureKind::Along(n) => (dot(n, x), dot(n, d), n),
            MeasureKind::Radial(rest, soft) => {
                let now = [0, 1, 2].map(|k| rest[k] + x[k]);
                let before = difference(now, d);
                let both = [0, 1, 2].map(|k| now[k] + before[k]);
                let (l, l0) = ((dot(now, now) + soft).sqrt(), (dot(before, before) + soft).sqrt());
                (l, dot(both, d) / (l + l0).max(f64::MIN_POSITIVE), now.map(|v| v / l.max(f64::MIN_POSITIVE)))
            }
        }
    }
}
