//! Curves of any length in bounded memory, as minimum and maximum of each interval.
//!
//! Both extremes of an interval are stored in the order of their time, not every n-th value, so a peak of one sample
//! stays visible in any length. The length need not be known: full columns are joined in pairs of twice the width.

use crate::plot::Grid;

/// Smallest number of columns of a long curve; the largest is twice that.
const COLUMNS: usize = 512;

/// Minimum and maximum of a column, each with the number of its frame; NaN without values.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extremes {
    least: (f64, u64),
    most: (f64, u64),
}

impl Extremes {
    const NONE: Extremes = Extremes { least: (f64::NAN, 0), most: (f64::NAN, 0) };

    fn join(&mut self, other: Extremes) {
        // comparisons with NaN are false
        if self.least.0.is_nan() || other.least.0 < self.least.0 {
            self.least = other.least;
        }
        if self.most.0.is_nan() || other.most.0 > self.most.0 {
            self.most = other.most;
        }
    }
}

/// Several curves over the same time.
#[derive(Clone, Debug)]
pub struct Envelope {
    rate: f64,
    curves: usize,
    /// Frames of a column.
    width: u64,
    frames: u64,
    /// Extremes (columns × curves).
    columns: Vec<Extremes>,
}

impl Envelope {
    /// Returns an empty envelope of `curves` curves with `rate` frames a second \[Hz\], from time 0.
    pub fn new(rate: f64, curves: usize) -> Envelope {
        Envelope { rate, curves, width: 1, frames: 0, columns: Vec::new() }
    }

    /// Appends a frame, one value for each curve. Non-finite values are gaps.
    pub fn push(&mut self, frame: &[f64]) {
        if self.frames.is_multiple_of(self.width) {
            if self.columns.len() == 2 * COLUMNS * self.curves {
                self.halve();
            }
            if self.frames.is_multiple_of(self.width) {
                self.columns.extend((0..self.curves).map(|_| Extremes::NONE));
            }
        }
        let at = self.columns.len().saturating_sub(self.curves);
        for (column, v) in self.columns[at..].iter_mut().zip(frame).filter(|(_, v)| v.is_finite()) {
            let here = (*v, self.frames);
            column.join(Extremes { least: here, most: here });
        }
        self.frames += 1;
    }

    /// Returns the number of frames so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    fn halve(&mut self) {
        let n = self.curves;
        for i in 0..COLUMNS {
            for k in 0..n {
                let mut both = self.columns[2 * i * n + k];
                both.join(self.columns[(2 * i + 1) * n + k]);
                self.columns[i * n + k] = both;
            }
        }
        self.columns.truncate(COLUMNS * n);
        self.width *= 2;
    }

    /// Returns the times of the points \[s\]: one for each frame of a short curve, two for each column of a long one.
    pub fn grid(&self) -> Grid {
        let columns = self.columns.len() / self.curves.max(1);
        if self.width == 1 {
            return Grid::Even { start: 0.0, step: 1.0 / self.rate, n: columns };
        }
        let step = 0.5 * self.width as f64 / self.rate;
        Grid::Even { start: 0.5 * step, step, n: 2 * columns }
    }

    /// Returns the points of one curve.
    pub fn curve(&self, k: usize) -> Vec<f64> {
        let columns = self.columns.iter().skip(k).step_by(self.curves.max(1));
        if self.width == 1 {
            return columns.map(|c| c.least.0).collect();
        }
        let ordered = |c: &Extremes| if c.least.1 <= c.most.1 { [c.least.0, c.most.0] } else { [c.most.0, c.least.0] };
        columns.flat_map(ordered).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every peak stays at its time, for any length.
    #[test]
    fn a_peak_of_one_frame_stays() {
        for frames in [1_u64, 2, 700, 1023, 1024, 1025, 5000, 1_000_003] {
            for at in [0, frames / 3, frames - 1] {
                let mut e = Envelope::new(1000.0, 2);
                (0..frames).for_each(|n| e.push(&[if n == at { 7.0 } else { 0.0 }, -(n as f64)]));
                let (Grid::Even { start, step, n }, spike, ramp) = (e.grid(), e.curve(0), e.curve(1)) else {
                    panic!("time is even");
                };
                assert_eq!((spike.len(), ramp.len()), (n, n));
                assert!(n as u64 == frames || (2 * COLUMNS..=4 * COLUMNS).contains(&n), "{frames} frames, {n} points");
                let i = spike.iter().position(|v| *v == 7.0).expect("the peak");
                let shown = spike.iter().filter(|v| **v == 7.0).count();
                assert!(shown == 1 || at == frames - 1, "twice only where it is alone in its column");
                let (there, here) = (at as f64 / 1000.0, start + i as f64 * step);
                assert!((here - there).abs() <= 2.0 * step, "{frames}: {there} s is shown at {here} s");
                // a falling curve falls, from the first value to the last
                assert!(ramp.windows(2).all(|w| w[0] >= w[1]));
                assert_eq!((ramp[0], ramp[n - 1]), (0.0, -((frames - 1) as f64)));
            }
        }
    }

    #[test]
    fn what_has_no_value_is_a_gap() {
        let mut e = Envelope::new(1.0, 1);
        for n in 0..4096 {
            e.push(&[if (1000..3000).contains(&n) { [f64::NAN, f64::INFINITY][n % 2] } else { 1.0 }]);
        }
        let curve = e.curve(0);
        let gaps = curve.iter().filter(|v| v.is_nan()).count();
        assert_eq!(gaps, 2 * 500, "of columns of 4 frames, two points each");
        assert!(curve.iter().all(|v| v.is_nan() || *v == 1.0));
    }
}
