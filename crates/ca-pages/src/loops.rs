//! Timing of the real-time loop, for the page of a take.
//!
//! The loop time runs from one device frame to the first frame sampled under the force that answers it. Both ends are
//! stamped by the device process (`t_host_ns`), because force frames are recorded before they are sent.

use ca_haptic::take::Rt;
use ca_model::quantity::short;
use ca_report::{Axis, Block, Curve, Grid, Look, Plot, Section, Table};
use std::collections::VecDeque;

/// Margin for the age of a frame when the engine takes it \[s\].
const AWAY: f64 = 5.0;
/// Histogram columns per decade.
const BINS: f64 = 25.0;

#[derive(Default)]
pub(crate) struct Loops {
    /// Times between device frames, and from a frame to the first one under its answering force \[µs\].
    pub(crate) intervals: Vec<f64>,
    pub(crate) around: Vec<f64>,
    pub(crate) seconds: Vec<Rt>,
}

/// Plots how many times \[µs\] fall into each logarithmic column.
fn histogram(title: &str, times: &[f64]) -> Option<Plot> {
    let bin = |t: f64| (t.log10() * BINS).floor() as i64;
    let some = || times.iter().copied().filter(|t| *t > 0.0);
    let (from, to) = some().map(bin).fold((i64::MAX, i64::MIN), |(a, b), i| (a.min(i), b.max(i)));
    if from > to {
        return None;
    }
    let mut counts = vec![0.0; (to - from + 1) as usize];
    some().for_each(|t| counts[(bin(t) - from) as usize] += 1.0);
    let middle = |i: usize| 10f64.powf(((from + i as i64) as f64 + 0.5) / BINS);
    Some(Plot {
        title: title.into(),
        x: Axis::log("time", "µs").over(10f64.powf((from - 1) as f64 / BINS), 10f64.powf((to + 2) as f64 / BINS)),
        y: Axis::log("frames", "").over(0.5, 2.0 * counts.iter().copied().fold(1.0, f64::max)),
        grid: Grid::Points((0..counts.len()).map(middle).collect()),
        curves: vec![Curve { name: "frames".into(), y: counts, look: Look::Bars }],
        marks: Vec::new(),
        image: None,
    })
}

/// Builds a row with the count, percentiles and maximum of `times` \[µs\]. Returns `None` without times.
fn row(name: &str, mut times: Vec<f64>) -> Option<Vec<String>> {
    times.sort_by(f64::total_cmp);
    let at = |q: f64| times.get(((times.len().saturating_sub(1)) as f64 * q).round() as usize).map(|t| short(*t));
    Some(vec![name.into(), times.len().to_string(), at(0.5)?, at(0.99)?, at(0.999)?, at(1.0)?])
}

impl Loops {
    pub(crate) fn section(self, rate: f64, gesture: f64) -> Option<Section> {
        let mut blocks = Vec::new();
        blocks.extend(histogram("Time between device frames", &self.intervals).map(Block::Plot));
        blocks.extend(histogram("Loop time from hand to force to hand", &self.around).map(Block::Plot));
        if let Some(last) = self.seconds.last() {
            let curve = |name: &str, of: fn(&Rt) -> f64| Curve::line(name, self.seconds.iter().map(of).collect());
            let times = Grid::Points(self.seconds.iter().map(|s| s.tick as f64 / rate).collect());
            let curves =
                vec![curve("median", |s| s.late_p50), curve("99 %", |s| s.late_p99), curve("largest", |s| s.late_max)];
            blocks.push(Block::Plot(Plot::over_time(
                "Lateness of gesture frames, per second",
                Axis::log("lateness", "µs"),
                times,
                curves,
            )));
            blocks.push(Block::Table(Table::pairs([
                ("gesture frames", format!("{}, {} per second", last.frames, short(gesture))),
                ("missed frames", last.missed.to_string()),
                ("frames without new device data", last.stale.to_string()),
                ("device frames refused", last.dropped.to_string()),
                ("faults", last.faults.to_string()),
                ("sound samples at the peak limit", last.clipped.to_string()),
                ("underruns of the sound device", last.underruns.to_string()),
                ("load in the last second", format!("{:.1} %", 100.0 * last.busy)),
            ])));
        }
        let rows: Vec<Vec<String>> =
            [row("between device frames", self.intervals), row("hand to force to hand", self.around)]
                .into_iter()
                .flatten()
                .collect();
        if !rows.is_empty() {
            let head = ["time [µs]", "frames", "median", "99 %", "99.9 %", "largest"];
            blocks.push(Block::Table(Table::new(&head, rows)));
        }
        (!blocks.is_empty()).then(|| Section::new("Real time", blocks))
    }
}

/// Recent frames of a device, used to measure the loop.
#[derive(Clone, Default)]
pub(crate) struct Clock {
    pub(crate) session: u64,
    pub(crate) last: Option<Stamp>,
    /// Recent device frames: sequence number and stamp.
    pub(crate) frames: VecDeque<(u64, Stamp)>,
    /// Recent force frames: sequence number, and stamp of the device frame that they answer.
    pub(crate) forces: VecDeque<(u64, Stamp)>,
}

/// Time at which a device published a frame \[ns\], and time at which the engine took it \[s\].
#[derive(Clone, Copy)]
pub(crate) struct Stamp {
    pub(crate) ns: u64,
    pub(crate) taken: f64,
}

impl Stamp {
    /// Returns the time since `earlier` \[µs\]. Returns `None` if the clock of the device is not the host clock or is
    /// invalid: the stamps then differ by more than the time that can have passed.
    pub(crate) fn since(self, earlier: Stamp) -> Option<f64> {
        let us = self.ns.checked_sub(earlier.ns)? as f64 * 1e-3;
        (us <= 1e6 * (self.taken - earlier.taken + AWAY)).then_some(us)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_none_makes_no_time_of_the_loop() {
        let (a, b) = (Stamp { ns: 5_000_000, taken: 0.0 }, Stamp { ns: 5_700_000, taken: 0.001 });
        assert_eq!(b.since(a), Some(700.0));
        assert_eq!(a.since(b), None);
        let never = Stamp { ns: u64::MAX, taken: 0.002 };
        assert_eq!((never.since(a), a.since(never)), (None, None));
    }
}
