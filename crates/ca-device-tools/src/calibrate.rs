//! Calibration: conversion from device readings to metres.
//!
//! Two readings per degree of freedom, at the stops, give scale, offset and direction, because the profile has the
//! distance of the stops. A [`Reader`] acts as the only server and sends no forces, so no engine moves the device. A
//! reading is the median of many frames while the hand holds the device still. An axis without readings keeps its
//! calibration.

use crate::ToolError;
use ca_haptic::calibration::{Axis, Calibration};
use ca_haptic::frame::{DeviceFrame, text};
use ca_haptic::host::gateway::list_devices;
use ca_haptic::host::{Gateway, Site};
use ca_haptic::profile::Profile;
use std::fmt;
use std::time::{Duration, Instant};

/// Frames per reading.
const READING: usize = 100;
/// Longest wait for the frames of a reading.
const PATIENCE: Duration = Duration::from_secs(5);
/// Largest motion during a reading, as a share of the distance of the stops.
const STILL: f64 = 0.02;

/// Completes the profile `unknown` from the device's own description, if the device is running. Returns any other
/// profile unchanged.
///
/// # Errors
/// If the description does not give a profile.
pub fn described(name: &str, profile: Profile) -> Result<Profile, ToolError> {
    if !profile.is_unknown() {
        return Ok(profile);
    }
    // a running device describes its axes and the distance of its stops
    let heard = Site::of_user().and_then(|site| list_devices(&site, PATIENCE)).unwrap_or_default();
    match heard.iter().find(|a| text(&a.device) == name) {
        Some(about) => profile.described(about).map_err(|e| ToolError::Failed(format!("`{name}`: {e}"))),
        None => Ok(profile),
    }
}

/// Computes the calibration of a device from the low and the high stop of each axis; an axis without stops keeps its
/// `old` calibration.
///
/// # Errors
/// If the stops of an axis are not two different numbers, or an axis has neither stops nor a calibration.
pub fn calibration(
    device: &str,
    by: String,
    stops: &[Option<[f64; 2]>],
    profile: &Profile,
    old: &Calibration,
) -> Result<Calibration, ToolError> {
    let mut axes = Vec::new();
    for (k, stops) in stops.iter().enumerate() {
        axes.push(match stops {
            Some(stops) => {
                axis(*stops, profile, old.axis.get(k)).map_err(|e| ToolError::Failed(format!("axis {k}: {e}")))?
            }
            None => *old.axis.get(k).ok_or_else(|| {
                let what = format!("axis {k} was skipped, but it does not have an earlier calibration");
                ToolError::Failed(format!("{what}; nothing was written; calibrate all axes"))
            })?,
        });
    }
    Ok(Calibration { device: device.into(), by, axis: axes })
}

/// Readings at two stops that do not define a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoLine {
    /// Reading at the low stop.
    pub low: f64,
    /// Reading at the high stop.
    pub high: f64,
}

impl fmt::Display for NoLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NoLine { low, high } = self;
        write!(f, "the readings at the low and high stop are {low} and {high}; they must be two different numbers")
    }
}

impl std::error::Error for NoLine {}

/// Computes the line through two stops; the factor of forces is unchanged.
///
/// # Errors
/// If the stops are not two different numbers.
pub fn axis([low, high]: [f64; 2], profile: &Profile, old: Option<&Axis>) -> Result<Axis, NoLine> {
    let [a, b] = profile.range;
    let scale = (b - a) / (high - low);
    if !(scale.is_finite() && low.is_finite() && scale != 0.0) {
        return Err(NoLine { low, high });
    }
    Ok(Axis { scale, offset: a - scale * low, force: old.map_or(1.0, |o| o.force) })
}

/// Reading of an axis at a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopReading {
    /// Median.
    pub position: f64,
    /// Motion during the reading.
    pub moved: f64,
}

/// Returns both stops of an axis; `None` if one moved during the reading, or both are in the same place.
pub fn stops(low: StopReading, high: StopReading) -> Option<[f64; 2]> {
    let way = (low.position - high.position).abs();
    (way > 0.0 && low.moved.max(high.moved) <= STILL * way).then_some([low.position, high.position])
}

/// Receives the frames of a device.
pub struct Reader {
    lines: Gateway,
    name: String,
}

impl Reader {
    /// Opens the services of the device as its server, and waits until the device sends frames.
    ///
    /// # Errors
    /// If another server has the device, or the device does not send.
    pub fn open(name: &str) -> Result<Reader, ToolError> {
        let mut reader = Reader { lines: Gateway::open(&Site::of_user()?, &[name])?, name: name.into() };
        reader.frames()?;
        Ok(reader)
    }

    /// Reads axis `k` at the present position of the device.
    ///
    /// # Errors
    /// If the device has stopped sending.
    pub fn stop(&mut self, k: usize) -> Result<StopReading, ToolError> {
        // discards earlier frames in the queue
        self.lines.poll(&mut |_, _| {});
        let mut x: Vec<f64> = self.frames()?.iter().map(|f| f.pos[k]).collect();
        x.sort_by(f64::total_cmp);
        Ok(StopReading { position: x[x.len() / 2], moved: x[x.len() - 1] - x[0] })
    }

    /// Collects frames of the device from now on.
    fn frames(&mut self) -> Result<Vec<DeviceFrame>, ToolError> {
        let (mut frames, end) = (Vec::new(), Instant::now() + PATIENCE);
        while frames.len() < READING {
            self.lines.poll(&mut |_, f| frames.push(f));
            if Instant::now() > end {
                let what =
                    format!("`{}` sent {} frames in {PATIENCE:?}, but {READING} are needed", self.name, frames.len());
                let fix = "start the device (`ca device list` shows running devices)";
                return Err(ToolError::Failed(format!("{what}; {fix}")));
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        Ok(frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_stops_make_a_line_in_either_direction() {
        let p = Profile::shipped("tgr12").expect("shipped");
        for stops in [[0.0, 4095.0], [4095.0, 0.0], [-0.3, 0.7]] {
            let a = axis(stops, &p, Some(&Axis { force: 3.0, ..Axis::default() })).expect("a line");
            for (s, x) in stops.iter().zip(p.range) {
                assert!((a.scale * s + a.offset - x).abs() < 1e-15, "{stops:?}");
            }
            assert_eq!(a.force, 3.0);
        }
        for bad in [[1.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
            assert!(axis(bad, &p, None).is_err(), "{bad:?}");
        }
    }
}
