//! Makes the points of a gesture: a line, a sine, noise, pulses, another gesture, a sum.

use super::{Curves, DAY, MOST, Points};
use crate::findings::{unit_in_sentence, unit_span, wrong_unit};
use alloc::format;
use alloc::vec::Vec;
use ca_core::{ABOVE_ZERO, ANY, Dim, Unit};
use ca_model::diag::Diag;
use ca_model::quantity::{self, Plain};
use ca_model::suggest::nearest;
use ca_model::{Entry, Span, Value};
use core::f64::consts::PI;

/// Largest number of gestures that follow one another.
const DEEP: usize = 16;
/// Points per period of a sine, which make it accurate to 5e-4 of its amplitude.
const OF_PERIOD: f64 = 100.0;

/// Evaluation of one table.
pub(super) struct CurveBuilder<'m, 'a, 'v> {
    pub(super) c: &'m mut Curves<'a, 'v>,
    pub(super) t: &'m [Entry],
    pub(super) at: Span,
    pub(super) what: &'m str,
}

impl CurveBuilder<'_, '_, '_> {
    fn find(&self, key: &str) -> Option<&Entry> {
        self.t.iter().find(|x| x.key == key)
    }

    fn constant(&mut self, e: &Entry, unit: Unit, range: (f64, f64)) -> Option<f64> {
        let what = format!("`{}` of {}", if e.key.is_empty() { "a value" } else { &e.key }, self.what);
        self.c.v.constant(e, unit, range, &what)
    }

    fn time(&mut self, key: &str, or: f64, range: (f64, f64)) -> Option<f64> {
        let Some(e) = self.find(key).cloned() else { return Some(or) };
        self.constant(&e, Unit::SECOND, range)
    }

    fn value(&mut self, e: &Entry) -> Option<f64> {
        self.c.v.alg = self.c.alg;
        let value = self.constant(e, self.c.unit, ANY);
        self.c.v.alg = None;
        value
    }

    fn offset(&mut self) -> Option<f64> {
        self.find("offset").cloned().map_or(Some(0.0), |e| self.value(&e))
    }

    fn number(&mut self, key: &str, or: f64, range: (f64, f64)) -> Option<f64> {
        let Some(e) = self.find(key).cloned() else { return Some(or) };
        self.constant(&e, Unit::NONE, range)
    }

    /// Returns the end \[s\], as written or of the model.
    fn end(&mut self) -> Option<f64> {
        let end = self.time("to", self.c.net.seconds.unwrap_or(f64::NAN), (0.0, DAY))?;
        if end.is_nan() {
            let d = Diag::error("E005", format!("the end of {} is missing", self.what)).at(self.at, "without `to`");
            self.c.v.diags.push(d.help("add the end in seconds, e.g. `to = 4`, or `seconds` in `[model]`"));
            return None;
        }
        Some(end)
    }

    fn span(&mut self) -> Option<(f64, f64)> {
        let (from, to) = (self.time("from", 0.0, (0.0, DAY))?, self.end()?);
        if to < from {
            let (from, to) = (Plain(from), Plain(to));
            let d = Diag::error("E019", format!("{} begins at {from} s and ends at {to} s", self.what));
            self.c
                .v
                .diags
                .push(d.at(self.at, "ends before it begins").help("write a later `to`, or an earlier `from`"));
            return None;
        }
        Some((from, to))
    }

    fn missing<T>(&mut self, key: &str, such: &str) -> Option<T> {
        let d = Diag::error("E005", format!("{} needs `{key}`", self.what)).at(self.at, format!("without `{key}`"));
        self.c.v.diags.push(d.help(format!("add e.g. `{key} = {such}`")));
        None
    }

    fn frequency(&mut self) -> Option<f64> {
        let Some(e) = self.find("f").cloned() else { return self.missing("f", "\"2 Hz\"") };
        self.constant(&e, Unit::HERTZ, (f64::MIN_POSITIVE, self.c.net.rate / 2.0))
    }

    /// Samples a curve `rate` times per second over an interval.
    fn sampled(&mut self, (from, to): (f64, f64), rate: f64, at: impl FnMut(f64) -> f64) -> Option<Points> {
        let n = libm::ceil((to - from).max(0.0) * rate) + 1.0;
        if n > MOST as f64 {
            return self.too_many();
        }
        let n = n as usize;
        let times = (0..n).map(|i| if i + 1 == n { to.max(from) } else { from + i as f64 / rate });
        let mut at = at;
        Some(times.map(|t| [t, at(t)]).collect())
    }

    fn too_many<T>(&mut self) -> Option<T> {
        let d = Diag::error("E027", format!("{} has more than {MOST} points", self.what)).at(self.at, "too long");
        self.c.v.diags.push(d.help("end it sooner, or play it from a file"));
        None
    }

    fn cut(&mut self, mut points: Points, end: f64) -> Option<Points> {
        let after = points.partition_point(|p| p[0] <= end);
        if after < points.len() && after > 0 {
            let last = value_at(&points, end, true);
            points.truncate(after);
            points.push([end, last]);
        } else {
            points.truncate(after);
        }
        if points.is_empty() { self.nothing() } else { Some(points) }
    }

    fn nothing<T>(&mut self) -> Option<T> {
        let d = Diag::error("E019", format!("{} has no points", self.what)).at(self.at, "empty");
        self.c.v.diags.push(d.help("add points, or leave it out"));
        None
    }

    /// Repeats points.
    pub(super) fn looped(&mut self, of: &Entry) -> Option<Points> {
        let what = self.what;
        let once = self.c.points(of, what)?;
        if self.find("every").is_none() {
            return Some(once);
        }
        let last = once.last().map_or(0.0, |p| p[0]);
        let (every, end) = (self.time("every", last, ABOVE_ZERO)?, self.end()?);
        if last > every {
            let (last, every) = (Plain(last), Plain(every));
            let d = Diag::error("E019", format!("{what} lasts {last} s, but repeats every {every} s"));
            let d = d.at(self.at, "too long");
            self.c.v.diags.push(d.help("make `every` longer, or leave out the points after it"));
            return None;
        }
        let times = libm::ceil(end / every);
        if times * once.len() as f64 > MOST as f64 {
            return self.too_many();
        }
        let mut all = Vec::new();
        for i in 0..times as usize {
            let start = i as f64 * every;
            all.extend(once.iter().map(|p| [start + p[0], p[1]]));
        }
        self.cut(all, end)
    }

    pub(super) fn ramp(&mut self, of: &Entry) -> Option<Points> {
        let Value::List(ends) = &of.value else { return self.not_two(of) };
        let [a, b] = &ends[..] else { return self.not_two(of) };
        let (a, b) = (self.value(a)?, self.value(b)?);
        let (from, to) = self.span()?;
        Some(Vec::from([[from, a], [to, b]]))
    }

    fn not_two<T>(&mut self, of: &Entry) -> Option<T> {
        let d = Diag::error("E019", format!("`ramp` of {} must have a first and a last value", self.what));
        let two = "write e.g. `ramp = [0, \"20 mm\"]`";
        self.c.v.diags.push(d.at(of.span, "not two values").help(two));
        None
    }

    pub(super) fn sine(&mut self, of: &Entry) -> Option<Points> {
        let (amplitude, f, offset) = (self.value(of)?, self.frequency()?, self.offset()?);
        let phase = self.number("phase", 0.0, (-1e6, 1e6))?;
        let (from, to) = self.span()?;
        let net = self.c.net;
        let frames = net.rate / f64::from(net.ratio.max(1));
        let rate = if f * OF_PERIOD > frames { net.rate } else { frames };
        let turns = |t: f64| f * (t - from) + phase;
        self.sampled((from, to), rate, |t| offset + amplitude * libm::sin(2.0 * PI * turns(t)))
    }

    /// Draws 2 f values per second, uniformly distributed around the offset.
    pub(super) fn noise(&mut self, of: &Entry) -> Option<Points> {
        let (amplitude, f, offset) = (self.value(of)?, self.frequency()?, self.offset()?);
        let seed = self.number("seed", 1.0, (0.0, 9e15))?;
        let (from, to) = self.span()?;
        let mut state = seed as u64;
        self.sampled((from, to), 2.0 * f, |_| offset + amplitude * (2.0 * uniform(&mut state) - 1.0))
    }

    /// Makes pulses: rise, hold, fall, once or repeatedly.
    pub(super) fn pulse(&mut self, of: &Entry) -> Option<Points> {
        let (height, offset) = (self.value(of)?, self.offset()?);
        let rise = self.time("rise", 0.0, (0.0, DAY))?;
        let hold = self.time("hold", 0.0, (0.0, DAY))?;
        let fall = self.time("fall", rise, (0.0, DAY))?;
        if rise + hold + fall == 0.0 {
            return self.missing("hold", "\"50 ms\"` or `rise = \"20 ms\"");
        }
        let mut starts = match self.find("at").cloned() {
            None => Vec::from([0.0]),
            Some(Entry { value: Value::List(list), .. }) => {
                list.iter().map(|e| self.constant(e, Unit::SECOND, (0.0, DAY))).collect::<Option<_>>()?
            }
            Some(e) => Vec::from([self.constant(&e, Unit::SECOND, (0.0, DAY))?]),
        };
        if self.find("every").is_some() {
            if starts.len() > 1 {
                let d =
                    Diag::error("E010", format!("{}: `every` and a list of times `at` exclude each other", self.what));
                self.c.v.diags.push(
                    d.at(self.at, "both are written").help("write only the first time in `at`, or leave out `every`"),
                );
                return None;
            }
            let every = self.time("every", 1.0, ABOVE_ZERO)?;
            let (first, end) = (starts.first().copied().unwrap_or(0.0), self.end()?);
            let n = libm::ceil((end - first).max(0.0) / every);
            if n * 4.0 > MOST as f64 {
                return self.too_many();
            }
            starts = (0..n as usize).map(|i| first + i as f64 * every).collect();
        }
        let mut points: Points = Vec::new();
        for start in starts {
            if points.last().is_some_and(|p| p[0] > start) {
                let d = Diag::error("E019", format!("{}: a pulse begins before the previous one ends", self.what));
                self.c.v.diags.push(d.at(self.at, format!("at {} s", Plain(start))).help("shorten it, or begin later"));
                return None;
            }
            let up = start + rise;
            let ends =
                [[start, offset], [up, offset + height], [up + hold, offset + height], [up + hold + fall, offset]];
            points.extend(ends);
        }
        match self.find("to").is_some() || self.find("every").is_some() {
            true => {
                let end = self.end()?;
                self.cut(points, end)
            }
            false if points.is_empty() => self.nothing(),
            false => Some(points),
        }
    }

    pub(super) fn follow(&mut self, of: &Entry) -> Option<Points> {
        let Value::Text(name) = &of.value else {
            let d = Diag::error("E006", format!("`follow` of {} must be the name of a gesture", self.what));
            self.c.v.diags.push(d.at(of.span, "not a name").help("write e.g. `follow = \"key\"`"));
            return None;
        };
        let Some(other) = self.c.all.get(name.as_str()).copied() else {
            let d = Diag::error("E013", format!("{}: no gesture `{name}`", self.what)).at(of.span, "unknown");
            self.c.v.diags.push(match nearest(name, self.c.all.keys().copied()) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(of.span, format!("\"{near}\"")),
                None => d.help("name a key of `[gesture]`"),
            });
            return None;
        };
        if self.c.following.contains(name) || self.c.following.len() >= DEEP {
            let itself = self.c.following.contains(name);
            let how = if itself {
                "follows itself".into()
            } else {
                format!("is in a chain of more than {DEEP} gestures that follow each other")
            };
            let d = Diag::error("E019", format!("{} {how}", self.what)).at(of.span, "one too many");
            self.c.v.diags.push(d.help("give one of them points or a curve instead of `follow`"));
            return None;
        }
        // The followed gesture may have another unit. The gain then has the ratio of the units, or is a number in SI
        // units.
        let (own, alg) = (self.c.unit, self.c.alg);
        let theirs = (self.c.units)(name).unwrap_or(own);
        let ratio = Dim { m: own.dim.m - theirs.dim.m, kg: own.dim.kg - theirs.dim.kg, s: own.dim.s - theirs.dim.s };
        let gain = match self.find("gain").cloned() {
            Some(e) => {
                if let Value::Text(t) = &e.value
                    && let Ok(q) = quantity::parse(t)
                    && q.has_unit
                    && !q.dim.same(ratio)
                {
                    let (what, is) = (format!("`gain` of {}", self.what), quantity::unit_of(q.dim));
                    let d = wrong_unit(&what, &quantity::unit_of(ratio), &is, unit_span(&e, t));
                    let [a, b] = [own, theirs].map(|u| unit_in_sentence(u.symbol));
                    let help = format!(
                        "`gain` converts the unit of `{name}` ({b}) to the unit of this gesture ({a}); a plain number is \
                         in SI units"
                    );
                    self.c.v.diags.push(d.help(help));
                    return None;
                }
                self.constant(&e, Unit { symbol: own.symbol, dim: ratio }, ANY)?
            }
            None => 1.0,
        };
        let (offset, delay) = (self.offset()?, self.time("delay", 0.0, (0.0, DAY))?);
        if let Some(made) = self.c.made.get(name) {
            let points = made.as_ref()?.iter().map(|[t, v]| [t + delay, offset + gain * v]).collect();
            return Some(points);
        }
        self.c.following.push(name.clone());
        let what = format!("gesture `{name}`");
        (self.c.unit, self.c.alg) = (theirs, if theirs.dim.same(own.dim) { alg } else { None });
        let before = self.c.v.diags.list.len();
        let points = self.c.curve(other, &what);
        // Errors of the followed gesture are reported at its own place.
        self.c.v.diags.list.truncate(before);
        (self.c.unit, self.c.alg) = (own, alg);
        self.c.following.pop();
        self.c.made.insert(name.clone(), points.clone());
        Some(points?.into_iter().map(|[t, v]| [t + delay, offset + gain * v]).collect())
    }

    /// Adds curves at the times of all their points.
    pub(super) fn sum(&mut self, of: &Entry) -> Option<Points> {
        let Value::List(list) = &of.value else {
            let d = Diag::error("E019", format!("`sum` of {} must be a list", self.what)).at(of.span, "not a list");
            self.c
                .v
                .diags
                .push(d.help("write e.g. `sum = [{ sine = \"1 mm\", f = \"2 Hz\" }, [[0, 0], [1, \"4 mm\"]]]`"));
            return None;
        };
        let what = self.what;
        let all: Vec<Points> = list.iter().map(|e| self.c.curve(e, what)).collect::<Option<_>>()?;
        if all.iter().map(Vec::len).sum::<usize>() > MOST {
            return self.too_many();
        }
        let mut times: Vec<f64> = all.iter().flatten().map(|p| p[0]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        // The sum jumps where any curve jumps: one point before, one after.
        let mut jumping: Vec<f64> =
            all.iter().flat_map(|p| p.windows(2)).filter(|w| w[0][0] == w[1][0]).map(|w| w[0][0]).collect();
        jumping.sort_by(f64::total_cmp);
        let jumps = |t: f64| jumping.binary_search_by(|j| j.total_cmp(&t)).is_ok();
        let total = |t: f64, before: bool| all.iter().map(|p| value_at(p, t, before)).sum::<f64>();
        if times.is_empty() {
            return self.nothing();
        }
        let mut points = Vec::with_capacity(times.len());
        for t in times {
            if jumps(t) {
                points.push([t, total(t, true)]);
            }
            points.push([t, total(t, false)]);
        }
        Some(points)
    }
}

/// Returns the value at `t`; at a jump, the value before it if `before`, else the value after it.
fn value_at(p: &[[f64; 2]], t: f64, before: bool) -> f64 {
    let i = p.partition_point(|q| if before { q[0] < t } else { q[0] <= t });
    match (i.checked_sub(1).map(|k| p[k]), p.get(i)) {
        (Some([t0, a]), Some([t1, b])) if *t1 > t0 => a + (b - a) * (t - t0) / (t1 - t0),
        (_, Some([_, b])) if before || i == 0 => *b,
        (Some([_, a]), _) => a,
        (None, None) => 0.0,
        (None, Some([_, b])) => *b,
    }
}

/// Returns a number from 0 to 1 by SplitMix64, which gives the same bits on every machine.
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 18_446_744_073_709_551_616.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_has_its_values_and_its_jumps() {
        let p = [[0.0, 1.0], [1.0, 3.0], [1.0, 7.0], [2.0, 7.0]];
        for (t, before, value) in
            [(-1.0, false, 1.0), (0.5, false, 2.0), (1.0, true, 3.0), (1.0, false, 7.0), (9.0, false, 7.0)]
        {
            assert_eq!(value_at(&p, t, before), value, "at {t}");
        }
    }
}
