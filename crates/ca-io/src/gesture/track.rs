//! Tracks: one quantity as a function of time, and its evaluation.
//!
//! Every gesture is a piecewise-linear function, whatever its file: breakpoints with times, or samples at a rate.
//! Before the beginning it has its first value and after the end its last, so that a port always has a value. Two
//! breakpoints at one time are a jump; the later one applies from that time on. Splines are not used because they
//! overshoot: a striking hand must not be pushed below the string.
//!
//! Values and times are finite by construction, and so are interpolated values: bad input never reaches a model.

use crate::error::FileError;
use ca_core::internal::numeric::Plain;

/// Greatest time of a gesture, on either side of zero \[s\]: a day, the greatest length of a performance.
pub const LONGEST: f64 = 86_400.0;

/// Highest sample rate \[Hz\], and inverse of the lowest.
const FASTEST: f64 = 1e9;

/// Makes the error for a time beyond [`LONGEST`] \[s\].
pub(super) fn too_long(t: f64) -> FileError {
    let what = format!("the time is {} s, and a gesture lasts {} s at most", Plain(t), Plain(LONGEST));
    FileError::content(what).fix("cut the rest off, or write times in seconds")
}

/// Values of a track.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// Times \[s\] and values, at least one, with times that never decrease.
    Points(Vec<(f64, f64)>),
    /// Rate \[Hz\], and samples from time 0, at least one.
    Samples(f64, Vec<f64>),
}

/// One named quantity over time, in the unit of its port or live parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    name: String,
    curve: Curve,
}

impl Track {
    /// Makes a track through breakpoints (time \[s\], value). Times may repeat (a jump) but not decrease.
    ///
    /// # Errors
    /// If there is no point, times decrease or exceed [`LONGEST`], or a number is not finite.
    pub fn points(name: impl Into<String>, points: Vec<(f64, f64)>) -> Result<Track, FileError> {
        let name = name.into();
        let err = |i: usize, what: String| Err(FileError::content(what).at(format!("track `{name}`, point {i}")));
        if points.is_empty() {
            return Err(
                FileError::content(format!("track `{name}` has no value")).fix("give it a value or leave it out")
            );
        }
        for (i, &(t, v)) in points.iter().enumerate() {
            if !v.is_finite() {
                return err(i, format!("the value is {v}, not a finite number"));
            }
            if !t.is_finite() {
                return err(i, format!("the time is {} s, not a finite number", Plain(t)));
            }
            if t.abs() > LONGEST {
                return Err(too_long(t).at(format!("track `{name}`, point {i}")));
            }
            if i > 0 && t < points[i - 1].0 {
                return err(i, format!("time runs backwards, from {} s to {} s", Plain(points[i - 1].0), Plain(t)));
            }
        }
        Ok(Track { name, curve: Curve::Points(points) })
    }

    /// Makes a track of samples at `rate` \[Hz\], the first at time 0.
    ///
    /// # Errors
    /// If the rate is invalid, there is no sample, one is not finite, or the track is longer than [`LONGEST`].
    pub fn sampled(name: impl Into<String>, rate: f64, samples: Vec<f64>) -> Result<Track, FileError> {
        let name = name.into();
        check_rate(rate)?;
        if samples.is_empty() {
            return Err(
                FileError::content(format!("track `{name}` has no value")).fix("give it a value or leave it out")
            );
        }
        if let Some(i) = samples.iter().position(|v| !v.is_finite()) {
            let what = format!("the value is {}, not a finite number", samples[i]);
            return Err(FileError::content(what).at(format!("track `{name}`, sample {i}")));
        }
        let end = (samples.len() - 1) as f64 / rate;
        if end > LONGEST {
            return Err(too_long(end).at(format!("track `{name}`, sample {}", samples.len() - 1)));
        }
        Ok(Track { name, curve: Curve::Samples(rate, samples) })
    }

    /// Returns the same track under another name.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Track {
        self.name = name.into();
        self
    }

    /// Returns the name of its port or live parameter.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the values.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// Returns the time of the last value \[s\], 0 if none is after the beginning.
    pub fn duration(&self) -> f64 {
        match &self.curve {
            Curve::Points(p) => p[p.len() - 1].0.max(0.0),
            Curve::Samples(rate, v) => (v.len() - 1) as f64 / rate,
        }
    }

    /// Returns true if the value ever changes.
    pub fn moves(&self) -> bool {
        match &self.curve {
            Curve::Points(p) => p.iter().any(|q| q.1 != p[0].1),
            Curve::Samples(_, v) => v.iter().any(|q| *q != v[0]),
        }
    }

    /// Returns the number of breakpoints or samples; never 0.
    pub fn n_points(&self) -> usize {
        match &self.curve {
            Curve::Points(p) => p.len(),
            Curve::Samples(_, v) => v.len(),
        }
    }

    /// Returns the value at time `t` \[s\], by bisection; always finite.
    pub fn at(&self, t: f64) -> f64 {
        match &self.curve {
            Curve::Points(p) => between(p, p.partition_point(|q| q.0 <= t).saturating_sub(1), t),
            Curve::Samples(rate, v) => sample(*rate, v, t),
        }
    }

    /// Returns the value at time `t` \[s\], with the same bits as [`Track::at`], faster for consecutive times.
    ///
    /// `hint` is from the previous call, 0 at first. The cost is amortised O(1) while time increases, a bisection where
    /// it decreases, without allocation. The hint is a plain number so that an engine can own the track and its hint
    /// side by side.
    pub fn at_near(&self, hint: &mut usize, t: f64) -> f64 {
        match &self.curve {
            Curve::Samples(rate, v) => sample(*rate, v, t),
            Curve::Points(p) => {
                let mut i = (*hint).min(p.len() - 1);
                if p[i].0 > t || t.is_nan() {
                    i = p.partition_point(|q| q.0 <= t).saturating_sub(1);
                } else {
                    while i + 1 < p.len() && p[i + 1].0 <= t {
                        i += 1;
                    }
                }
                *hint = i;
                between(p, i, t)
            }
        }
    }

    /// Returns a reader of this track, from its beginning.
    pub fn cursor(&self) -> Cursor<'_> {
        Cursor { track: self, hint: 0 }
    }
}

/// Reads one track at increasing times.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    track: &'a Track,
    hint: usize,
}

impl Cursor<'_> {
    /// Returns the value at time `t` \[s\]; see [`Track::at_near`].
    pub fn at(&mut self, t: f64) -> f64 {
        self.track.at_near(&mut self.hint, t)
    }
}

pub(crate) fn check_rate(rate: f64) -> Result<(), FileError> {
    if rate.is_finite() && rate > 1.0 / FASTEST && rate < FASTEST {
        return Ok(());
    }
    Err(FileError::usage(format!("the rate is {} Hz", Plain(rate)))
        .fix("give samples per second between 1e-9 and 1e9, for example 3000"))
}

/// Returns the value at `t`, where `i` is the last point at or before `t`, or the first.
fn between(p: &[(f64, f64)], i: usize, t: f64) -> f64 {
    let (t0, a) = p[i];
    match p.get(i + 1) {
        Some(&(t1, b)) if t > t0 => mix(a, b, (t - t0) / (t1 - t0)),
        _ => a,
    }
}

fn sample(rate: f64, v: &[f64], t: f64) -> f64 {
    let x = t * rate;
    if x.is_nan() || x <= 0.0 {
        return v[0];
    }
    if x >= (v.len() - 1) as f64 {
        return v[v.len() - 1];
    }
    // (n / rate) · rate is not always n: the time of a sample gives that sample, to the bit
    let near = x.round();
    if (x - near).abs() <= near * (4.0 * f64::EPSILON) {
        return v[near as usize];
    }
    let i = x as usize;
    mix(v[i], v[i + 1], x - i as f64)
}

/// Interpolates between `a` and `b`, and never exceeds them, even if b − a overflows.
fn mix(a: f64, b: f64, u: f64) -> f64 {
    (a * (1.0 - u) + b * u).clamp(a.min(b), a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gesture_lasts_a_day_at_most() {
        for t in [86_401.0, -1e9] {
            let mut points = [(0.0_f64, 0.0), (t, 1.0)];
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            let e = Track::points("x", points.to_vec()).unwrap_err().to_string();
            assert!(e.contains(&format!("{} s, and a gesture lasts 86400 s at most", Plain(t))), "{e}");
        }
        assert!(Track::points("x", vec![(86_400.0, 1.0)]).is_ok());
        let e = Track::sampled("x", 1.0 / 131_072.0, vec![0.0, 1.0]).unwrap_err().to_string();
        assert!(e.contains("the time is 131072 s"), "{e}");
        assert!(Track::sampled("x", 96_000.0, vec![0.0; 3]).is_ok());
    }
    use proptest::prelude::*;

    #[test]
    fn holds_both_ends_and_is_linear_between() {
        let t = Track::points("x", vec![(1.0, 2.0), (3.0, 6.0), (4.0, 0.0)]).unwrap();
        for (time, want) in [(-1.0, 2.0), (1.0, 2.0), (1.5, 3.0), (3.0, 6.0), (3.25, 4.5), (4.0, 0.0), (99.0, 0.0)] {
            assert_eq!(t.at(time), want, "at {time}");
        }
        assert_eq!(t.duration(), 4.0);
        assert!(t.at(f64::NAN).is_finite() && t.at(f64::INFINITY) == 0.0 && t.at(f64::NEG_INFINITY) == 2.0);
    }

    #[test]
    fn a_repeated_time_is_a_jump() {
        let t = Track::points("x", vec![(0.0, 0.0), (1.0, 0.0), (1.0, 5.0), (2.0, 5.0)]).unwrap();
        assert_eq!(t.at(1.0 - 1e-12), 0.0);
        assert_eq!(t.at(1.0), 5.0);
        let mut c = t.cursor();
        assert_eq!((c.at(0.5), c.at(1.0), c.at(1.5), c.at(0.2)), (0.0, 5.0, 5.0, 0.0));
    }

    #[test]
    fn sample_times_give_samples_to_the_bit() {
        for rate in [44_100.0, 48_000.0, 3_000.0, 22_050.0] {
            let v: Vec<f64> = (0..50_000).map(|n| f64::from(n) * 0.1).collect();
            let t = Track::sampled("x", rate, v.clone()).unwrap();
            for (n, want) in v.iter().enumerate() {
                assert_eq!(t.at(n as f64 / rate), *want, "sample {n} at {rate} Hz");
            }
            assert_eq!(t.duration(), 49_999.0 / rate);
        }
        let t = Track::sampled("x", 10.0, vec![1.0, 2.0]).unwrap();
        assert_eq!((t.at(-1.0), t.at(0.05), t.at(9.0)), (1.0, 1.5, 2.0));
    }

    #[test]
    fn refuses_what_is_no_function_of_time() {
        for (points, say) in [
            (vec![], "no value"),
            (vec![(0.0, f64::NAN)], "value is NaN"),
            (vec![(0.0, 0.0), (f64::INFINITY, 1.0)], "time is inf"),
            (vec![(0.0, 0.0), (2e9, 1.0)], "time is"),
            (vec![(1.0, 0.0), (0.5, 1.0)], "backwards"),
        ] {
            let e = Track::points("x", points).unwrap_err();
            assert!(e.to_string().contains(say), "{e}");
        }
        assert!(Track::sampled("x", 0.0, vec![1.0]).is_err());
        assert!(Track::sampled("x", 1.0, vec![]).is_err());
        let e = Track::sampled("x", 1.0, vec![0.0, f64::INFINITY]).unwrap_err();
        assert!(e.to_string().contains("sample 1"), "{e}");
    }

    proptest! {
        #[test]
        fn the_cursor_reads_the_same_bits(
            mut times in prop::collection::vec(0.0..10.0f64, 1..40),
            values in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::ZERO, 40),
            reads in prop::collection::vec(-1.0..11.0f64, 1..60),
        ) {
            times.sort_by(f64::total_cmp);
            let points: Vec<_> = times.iter().copied().zip(values).collect();
            let (lo, hi) = points.iter().fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p.1), h.max(p.1)));
            let t = Track::points("x", points).unwrap();
            let mut c = t.cursor();
            for r in reads {
                let y = t.at(r);
                prop_assert_eq!(y.to_bits(), c.at(r).to_bits());
                prop_assert!(y >= lo && y <= hi);
            }
        }
    }
}
