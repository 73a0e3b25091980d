//! A built-in gesture as written: points, or a table that makes them.
//!
//! All gestures become points joined by straight lines before anything is played, as gestures from files are. There is
//! therefore one kind of gesture for players and takes. A sine has a point at every gesture frame, like the position of
//! a device; if it is too fast for that, it has one at every sample.

mod build;

use crate::lower::values::Values;
use crate::net::Resolved;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use build::CurveBuilder;
use ca_core::Unit;
use ca_core::internal::kind::alg_to_si;
use ca_model::diag::Diag;
use ca_model::quantity::Plain;
use ca_model::sections::CURVES;
use ca_model::suggest::nearest;
use ca_model::{Entry, Value};

/// Largest number of points.
pub const MOST: usize = 1 << 22;
/// Longest duration of a gesture \[s\].
const DAY: f64 = 86_400.0;

/// Points \[s, value\].
pub type Points = Vec<[f64; 2]>;

/// Context for the evaluation of curves.
pub struct Curves<'a, 'v> {
    pub v: &'a mut Values<'v>,
    pub net: &'a Resolved,
    /// All gestures as written.
    pub all: &'a BTreeMap<&'a str, &'a Entry>,
    /// Unit of the values.
    pub unit: Unit,
    /// Unit of any gesture, by its name.
    pub units: &'a dyn Fn(&str) -> Option<Unit>,
    /// Tick of the reference rate, if bare values are in `alg` units; times are always in seconds.
    pub alg: Option<f64>,
    /// Gestures being followed.
    pub following: Vec<String>,
    /// Gestures already made.
    pub made: &'a mut BTreeMap<String, Option<Points>>,
}

impl Curves<'_, '_> {
    /// Returns the points of a gesture; `None` after a reported error.
    pub fn curve(&mut self, e: &Entry, what: &str) -> Option<Points> {
        match &e.value {
            Value::Table(t) => self.made(e, t, what),
            _ => self.points(e, what),
        }
    }

    fn points(&mut self, e: &Entry, what: &str) -> Option<Points> {
        let mut points = self.v.points(e, Unit::SECOND, self.unit, what)?;
        let Value::List(list) = &e.value else { return None };
        if let Some(tr) = self.alg {
            for (p, written) in points.iter_mut().zip(list) {
                if let Value::List(pair) = &written.value {
                    if matches!(pair[1].value, Value::Num(_)) {
                        p[1] *= alg_to_si(self.unit.dim, tr);
                    }
                }
            }
        }
        if points.is_empty() {
            let d = Diag::error("E019", format!("{what} has no points")).at(e.span, "empty");
            self.v.diags.push(d.help("write `[[seconds, value], …]` with increasing times"));
            return None;
        }
        let back = (1..points.len()).find(|i| points[*i][0] < points[i - 1][0]);
        if let Some(i) = back {
            let (now, before) = (Plain(points[i][0]), Plain(points[i - 1][0]));
            let d = Diag::error("E019", format!("{what} goes back in time: {now} s after {before} s"));
            let d = d.at(list[i].span, "earlier than the point before").at(list[i - 1].span, "the point before");
            self.v.diags.push(d.help("write the points in order of time"));
            return None;
        }
        if let Some(i) = points.iter().position(|p| p[0] < 0.0) {
            let d = Diag::error("E019", format!("{what} begins before time 0: {} s", Plain(points[i][0])));
            self.v
                .diags
                .push(d.at(list[i].span, "before the beginning").help("times are seconds from the first sample"));
            return None;
        }
        if let Some(i) = points.iter().position(|p| p[0] > DAY) {
            let d = Diag::error("E009", format!("{what} has a point beyond a day: {} s", Plain(points[i][0])));
            self.v.diags.push(d.at(list[i].span, "out of range").help("times are seconds; use 86400 or less"));
            return None;
        }
        Some(points)
    }

    fn made(&mut self, e: &Entry, t: &[Entry], what: &str) -> Option<Points> {
        let makers = || CURVES.iter().map(|m| m.0);
        let found: Vec<&Entry> = t.iter().filter(|x| makers().any(|m| m == x.key)).collect();
        let [of] = found[..] else {
            let many = if found.is_empty() { "no curve" } else { "more than one curve" };
            let all = makers().map(|m| format!("`{m}`")).collect::<Vec<_>>().join(", ");
            let d = Diag::error("E019", format!("{what} defines {many}")).at(e.span, "needs one curve");
            self.v.diags.push(d.help(format!("write points, or a table with one of {all}; `sum` adds several")));
            return None;
        };
        let keys = CURVES.iter().find(|m| m.0 == of.key).map_or(&[][..], |m| m.1);
        let mut good = true;
        for x in t.iter().filter(|x| x.key != of.key && !keys.contains(&x.key.as_str())) {
            let d = Diag::error("E004", format!("{what}: a {} has no `{}`", of.key, x.key))
                .at(x.key_span, "not known here");
            let all = keys.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", ");
            self.v.diags.push(match nearest(&x.key, keys.iter().copied()) {
                Some(near) => d.help(format!("did you mean `{near}`?")).fix(x.key_span, near),
                None if keys.is_empty() => d.help(format!("`{}` does not take other keys", of.key)),
                None => d.help(format!("its keys are {all}")),
            });
            good = false;
        }
        let mut m = CurveBuilder { c: self, t, at: e.span, what };
        let points = match of.key.as_str() {
            "points" => m.looped(of),
            "ramp" => m.ramp(of),
            "sine" => m.sine(of),
            "noise" => m.noise(of),
            "pulse" => m.pulse(of),
            "follow" => m.follow(of),
            _ => m.sum(of),
        };
        points.filter(|_| good)
    }
}
