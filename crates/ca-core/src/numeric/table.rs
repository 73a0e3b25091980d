//! Piecewise-linear tables: laws that authors draw, and curves too expensive to compute each tick.
//!
//! Values are interpolated linearly and held constant outside, as in pmpd and GENESIS. The integral is stored beside
//! the values, so that a table spring has an exact potential and the energy ledger stays exact.

use crate::numeric::Real;
use alloc::vec::Vec;

/// A piecewise-linear function y(x).
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bytes",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "R: crate::numeric::Stored", into = "Points<R>", try_from = "Points<R>")
)]
pub struct Table<R: Real = f64> {
    /// abscissae, rising (n)
    x: Vec<R>,
    /// values (n)
    y: Vec<R>,
    /// integral of y from x = 0 (n)
    area: Vec<R>,
    /// 1/spacing if the abscissae are evenly spaced, else 0: an even table is indexed without a search
    per: R,
    /// largest and smallest slope of any segment
    slopes: (f64, f64),
    /// largest absolute value
    most: f64,
}

/// The numbers that define a table: abscissae, values, and 1/spacing or 0.
#[cfg(feature = "bytes")]
#[derive(serde::Serialize, serde::Deserialize)]
#[serde(bound = "R: crate::numeric::Stored")]
struct Points<R: Real> {
    x: Vec<R>,
    y: Vec<R>,
    per: R,
}

#[cfg(feature = "bytes")]
impl<R: Real> From<Table<R>> for Points<R> {
    fn from(table: Table<R>) -> Points<R> {
        Points { x: table.x, y: table.y, per: table.per }
    }
}

#[cfg(feature = "bytes")]
impl<R: Real> TryFrom<Points<R>> for Table<R> {
    type Error = &'static str;
    fn try_from(Points { x, y, per }: Points<R>) -> Result<Table<R>, &'static str> {
        let rises = x.len() >= 2 && x.windows(2).all(|x| x[1] > x[0]);
        let finite = x.iter().chain(&y).all(|v| v.is_finite()) && per.is_finite();
        if !(rises && finite && x.len() == y.len()) {
            return Err("the points of a table do not rise");
        }
        Ok(Table::of(x, y, per))
    }
}

impl Table {
    /// Makes a table, or `None` with fewer than two points, x that does not rise, or a number that is not finite.
    pub fn new(points: &[[f64; 2]]) -> Option<Table> {
        if points.len() < 2
            || points.windows(2).any(|p| p[1][0] <= p[0][0])
            || points.iter().flatten().any(|v| !v.is_finite())
        {
            return None;
        }
        let last = points.len() - 1;
        let step = (points[last][0] - points[0][0]) / last as f64;
        let even =
            points.iter().enumerate().all(|(i, p)| (p[0] - (points[0][0] + i as f64 * step)).abs() < 1e-9 * step);
        let per = if even { 1.0 / step } else { 0.0 };
        let [x, y] = [0, 1].map(|k| points.iter().map(|p| p[k]).collect::<Vec<_>>());
        Some(Table::of(x, y, per))
    }
}

impl<R: Real> Table<R> {
    /// Returns the same table over another number type, or `None` if its abscissae do not rise there.
    pub(crate) fn rounded<Q: Real>(&self) -> Option<Table<Q>> {
        let [x, y]: [Vec<Q>; 2] = [&self.x, &self.y].map(|all| all.iter().map(|v| Q::of(v.wide())).collect());
        let rises = x.windows(2).all(|x| x[1] > x[0]) && x.iter().chain(&y).all(|v| v.is_finite());
        rises.then(|| Table::of(x, y, Q::of(self.per.wide())))
    }

    fn of(x: Vec<R>, y: Vec<R>, per: R) -> Table<R> {
        let most = y.iter().fold(0.0, |most: f64, y| most.max(y.wide().abs()));
        let mut t = Table { area: alloc::vec![R::ZERO; x.len()], x, y, per, slopes: (f64::MIN, f64::MAX), most };
        for i in 1..t.x.len() {
            t.area[i] = t.area[i - 1] + R::of(0.5) * (t.y[i] + t.y[i - 1]) * (t.x[i] - t.x[i - 1]);
        }
        t.slopes = (0..t.x.len() - 1).map(|i| t.rise(i).wide()).fold(t.slopes, |(hi, lo), s| (s.max(hi), s.min(lo)));
        let zero = t.since_first(R::ZERO);
        t.area.iter_mut().for_each(|a| *a -= zero);
        t
    }

    /// Calls `visit` for each number of the table.
    pub fn numbers(&mut self, visit: &mut impl FnMut(&mut R)) {
        [&mut self.x, &mut self.y, &mut self.area].into_iter().flatten().for_each(&mut *visit);
        visit(&mut self.per);
    }

    /// Returns the segment that holds `x`, which lies between the ends.
    #[inline]
    fn segment(&self, x: R) -> usize {
        let last = self.x.len() - 2;
        let i = if self.per > R::ZERO {
            ((x - self.x[0]) * self.per).wide() as usize
        } else {
            self.x.partition_point(|v| *v <= x).saturating_sub(1)
        };
        i.min(last)
    }

    /// Returns the value at `x`; outside, the value at the nearer end.
    #[inline]
    pub fn at(&self, x: R) -> R {
        let n = self.x.len();
        if x <= self.x[0] {
            return self.y[0];
        }
        if x >= self.x[n - 1] {
            return self.y[n - 1];
        }
        let i = self.segment(x);
        let (x0, x1, y0, y1) = (self.x[i], self.x[i + 1], self.y[i], self.y[i + 1]);
        y0 + (y1 - y0) * ((x - x0) / (x1 - x0))
    }

    /// Returns the integral from the first point to `x`, while `area` is that.
    fn since_first(&self, x: R) -> R {
        let i = if self.spans(x) || x <= self.x[0] { self.segment(x.max(self.x[0])) } else { self.x.len() - 1 };
        self.area[i] + R::of(0.5) * (self.y[i] + self.at(x)) * (x - self.x[i])
    }

    /// Returns the integral from 0 to `x`. It starts at 0 in the segment that holds 0, and elsewhere at the nearer end
    /// of the segment, since areas of distant points would leave only their rounding where the integral is small.
    pub fn integral(&self, x: R) -> R {
        let last = self.x.len() - 1;
        let below = |x: R| x <= self.x[0];
        let above = |x: R| x >= self.x[last];
        let (holds_zero, near) = match () {
            () if below(x) => (below(R::ZERO), 0),
            () if above(x) => (above(R::ZERO), last),
            () => {
                let i = self.segment(x);
                let (from, to) = (self.x[i], self.x[i + 1]);
                (from <= R::ZERO && R::ZERO <= to, if x - from <= to - x { i } else { i + 1 })
            }
        };
        if holds_zero {
            return R::of(0.5) * (self.at(R::ZERO) + self.at(x)) * x;
        }
        self.area[near] + R::of(0.5) * (self.y[near] + self.at(x)) * (x - self.x[near])
    }

    fn rise(&self, i: usize) -> R {
        (self.y[i + 1] - self.y[i]) / (self.x[i + 1] - self.x[i])
    }

    /// Returns true between the ends, where the value depends on `x`.
    fn spans(&self, x: R) -> bool {
        self.x[0] <= x && x < self.x[self.x.len() - 1]
    }

    /// Returns the slope at `x`, 0 outside.
    pub fn slope(&self, x: R) -> R {
        if self.spans(x) { self.rise(self.segment(x)) } else { R::ZERO }
    }

    /// Returns y/x for a table that is 0 at 0, and the slope of the segments that meet there, which is free of noise.
    pub fn chord(&self, x: R) -> R {
        if self.spans(x) {
            let i = self.segment(x);
            if self.x[i] <= R::ZERO && self.x[i + 1] >= R::ZERO {
                return self.rise(i);
            }
        }
        if x == R::ZERO { R::ZERO } else { self.at(x) / x }
    }

    /// Returns the mean value between `a` and `s`, and its derivative by `s`. Integrals start at `a` and `s`: a
    /// difference of integrals from 0 would be all rounding where these are close.
    pub(crate) fn mean(&self, a: R, s: R) -> [R; 2] {
        let (half, n) = (R::of(0.5), self.x.len());
        // 0 before the first point, n after the last
        let piece = |x: R| match () {
            () if x < self.x[0] => 0,
            () if x >= self.x[n - 1] => n,
            () => 1 + self.segment(x),
        };
        let [low, high] = if a <= s { [a, s] } else { [s, a] };
        let [first, last] = [low, high].map(piece);
        let [at_low, at_high] = [low, high].map(|x| self.at(x));
        if first >= last {
            return [half * (at_low + at_high), half * self.slope(s)];
        }
        let before = half * (at_low + self.y[first]) * (self.x[first] - low);
        let behind = half * (self.y[last - 1] + at_high) * (high - self.x[last - 1]);
        let mean = (before + (self.area[last - 1] - self.area[first]) + behind) / (high - low);
        [mean, (self.at(s) - mean) / (s - a)]
    }

    pub(crate) fn most(&self) -> f64 {
        self.most
    }

    /// Returns the largest and smallest slope of any segment.
    pub fn slopes(&self) -> (f64, f64) {
        self.slopes
    }

    /// Returns the largest and smallest slope of the segments between two abscissae, with 0 for any part beyond the
    /// ends.
    pub(crate) fn slopes_between(&self, [from, to]: [f64; 2]) -> (f64, f64) {
        let within = |i: &usize| self.x[*i].wide() < to && self.x[*i + 1].wide() > from;
        let beyond = from < self.x[0].wide() || to > self.x[self.x.len() - 1].wide();
        let first = if beyond { (0.0, 0.0) } else { (f64::MIN, f64::MAX) };
        let all = (0..self.x.len() - 1).filter(within).map(|i| self.rise(i).wide());
        let (hi, lo) = all.fold(first, |(hi, lo), s| (s.max(hi), s.min(lo)));
        if hi < lo { (0.0, 0.0) } else { (hi, lo) }
    }

    /// Returns true if y has the sign of x everywhere. Such a table used as friction only takes energy.
    pub(crate) fn resists(&self) -> bool {
        self.x.iter().zip(&self.y).all(|(x, y)| *x * *y >= R::ZERO) && self.at(R::ZERO) == R::ZERO
    }
}
