//! Takes: device motion, forces and sound.

use crate::error::{failure, file};
use crate::long_call::{CallProgress, run_detached};
use crate::measure::table;
use crate::model::Model;
use ca_haptic::frame::{Cause, DOF, Mode};
use ca_haptic::take::{self, Event, Replay, ReplayVerdict};
use ca_io::{FileError, FileErrorKind};
use ca_lab::{Loaded, catalog};
use numpy::IntoPyArray as _;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// Longest gap in a sound in samples of all channels, an hour of one; a larger gap is an error.
const HOLE: u64 = 1 << 28;

#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Take {
    take: Arc<take::Take>,
}

/// Frames between the engine and one device.
#[derive(Default)]
struct Hand {
    dof: usize,
    tick: Vec<i64>,
    number: Vec<i64>,
    device_ns: Vec<i64>,
    status: Vec<u32>,
    position: Vec<f64>,
    measured: Vec<f64>,
    force_tick: Vec<i64>,
    answers: Vec<i64>,
    flags: Vec<u32>,
    injected: Vec<f64>,
    force: Vec<f64>,
    mode: Vec<&'static str>,
    cause: Vec<&'static str>,
}

impl Hand {
    fn dict(self, py: Python<'_>, rate: f64) -> PyResult<Bound<'_, PyDict>> {
        let d = PyDict::new(py);
        let (n, m) = (self.tick.len(), self.force_tick.len());
        d.set_item("time", seconds(self.tick, rate).into_pyarray(py))?;
        d.set_item("number", self.number.into_pyarray(py))?;
        d.set_item("device_time", seconds(self.device_ns, 1e9).into_pyarray(py))?;
        d.set_item("status", self.status.into_pyarray(py))?;
        d.set_item("position", table(py, self.position, n, self.dof)?)?;
        d.set_item("measured", table(py, self.measured, n, self.dof)?)?;
        d.set_item("force_time", seconds(self.force_tick, rate).into_pyarray(py))?;
        d.set_item("force", table(py, self.force, m, self.dof)?)?;
        d.set_item("answers", self.answers.into_pyarray(py))?;
        d.set_item("flags", self.flags.into_pyarray(py))?;
        d.set_item("injected", self.injected.into_pyarray(py))?;
        d.set_item("mode", self.mode)?;
        d.set_item("cause", self.cause)?;
        Ok(d)
    }
}

/// Columns of a take, by topic.
#[derive(Default)]
struct Columns {
    hands: Vec<Hand>,
    sound: Vec<f64>,
    energy: Vec<Vec<f64>>,
    rt: Vec<Vec<f64>>,
}

/// Reads all events, or until the call is interrupted.
fn events(take: &take::Take, wanted: &CallProgress) -> Result<Columns, FileError> {
    let mut all = Columns::default();
    for s in &take.header.setups {
        all.hands.push(Hand { dof: (s.profile.dof as usize).min(DOF), ..Hand::default() });
    }
    for event in take.events()?.take_while(|_| wanted.still()) {
        match event? {
            Event::Device(k, f) => {
                let h = &mut all.hands[k];
                h.tick.push(f.tick as i64);
                h.number.push(f.seq as i64);
                h.device_ns.push(f.t_device_ns as i64);
                h.status.push(f.status);
                h.position.extend(&f.pos[..h.dof]);
                h.measured.extend(f.force_measured[..h.dof].iter().map(|x| f64::from(*x)));
            }
            Event::Force(k, f) => {
                let h = &mut all.hands[k];
                h.force_tick.push(f.tick as i64);
                h.force.extend(f.force[..h.dof].iter().map(|x| f64::from(*x)));
                h.answers.push(f.ack as i64);
                h.flags.push(f.flags);
                h.injected.push(f64::from(f.inject));
                h.mode.push(Mode::read(f.mode).name());
                h.cause.push(Cause::read(f.cause).name());
            }
            Event::Sound(tick, samples) => {
                // lost sound becomes silence, so that times stay right
                let there = all.sound.len() as u64;
                let at = tick.checked_mul(take.header.channels.len() as u64);
                let at = at.filter(|n| (there..=there + HOLE).contains(n)).ok_or_else(|| {
                    let what = format!(
                        "the sound at sample {tick} does not follow the {there} samples (of all channels) before it"
                    );
                    FileError::new(FileErrorKind::Content, what)
                })?;
                all.sound.resize(at as usize, 0.0);
                all.sound.extend(samples);
            }
            Event::Energy(e) => {
                let t = e.tick as f64 / take.header.rate;
                all.energy.push(vec![t, e.h0, e.h, e.lost, e.source, e.work, e.changed, e.residual, e.peak]);
            }
            Event::Rt(r) => all.rt.push(vec![
                r.tick as f64 / take.header.rate,
                r.frames as f64,
                r.missed as f64,
                r.stale as f64,
                r.dropped as f64,
                r.faults as f64,
                r.clipped as f64,
                r.late_p50 * 1e-6,
                r.late_p99 * 1e-6,
                r.late_max * 1e-6,
                r.busy,
                r.underruns as f64,
            ]),
            _ => {}
        }
    }
    Ok(all)
}

fn seconds(ticks: Vec<i64>, rate: f64) -> Vec<f64> {
    ticks.into_iter().map(|t| t as f64 / rate).collect()
}

/// Columns by name.
fn columns<'py>(py: Python<'py>, names: &[&str], rows: &[Vec<f64>]) -> PyResult<Bound<'py, PyDict>> {
    let d = PyDict::new(py);
    for (k, name) in names.iter().enumerate() {
        let column: Vec<f64> = rows.iter().map(|r| r[k]).collect();
        d.set_item(*name, column.into_pyarray(py))?;
    }
    Ok(d)
}

#[pymethods]
impl Take {
    #[new]
    fn new(py: Python, path: PathBuf) -> PyResult<Take> {
        let take = run_detached(py, None, move |_| take::Take::open(&path))?.map_err(|e| file(py, &e))?;
        Ok(Take { take: Arc::new(take) })
    }

    /// Header of the take.
    fn about<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let h = &self.take.header;
        let d = PyDict::new(py);
        d.set_item("title", &h.title)?;
        d.set_item("rate", h.rate)?;
        d.set_item("gesture_rate", h.rate / f64::from(h.ratio))?;
        d.set_item("channels", h.channels.clone())?;
        d.set_item("devices", h.setups.iter().map(|s| s.device.clone()).collect::<Vec<_>>())?;
        d.set_item("began", h.began_ns as f64 * 1e-9)?;
        d.set_item("host", h.host.clone())?;
        Ok(d)
    }

    /// The model that was played, and its rate.
    fn model(&self, py: Python) -> PyResult<(Model, Option<f64>)> {
        let (model, diags) = self.take.header.model(&catalog()).map_err(|e| file(py, &e))?;
        let mut loaded = Loaded::built(model);
        loaded.diags = diags;
        loaded.clouds.clone_from(&self.take.header.options.clouds);
        Ok((Model::of(loaded), self.take.header.options.rate))
    }

    /// Everything in it: devices by name, sound, energy, real-time numbers, length, faults, losses, and its end.
    fn read<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (header, take) = (&self.take.header, self.take.clone());
        let found =
            run_detached(py, None, move |wanted| events(&take, wanted).and_then(|all| Ok((all, take.summary()?))))?;
        let (Columns { hands, sound, energy, rt }, summary) = found.map_err(|e| file(py, &e))?;
        let d = PyDict::new(py);
        let all = PyDict::new(py);
        for (s, h) in header.setups.iter().zip(hands) {
            all.set_item(&s.device, h.dict(py, header.rate)?)?;
        }
        d.set_item("devices", all)?;
        let channels = header.channels.len();
        let frames = sound.len().checked_div(channels).unwrap_or(0);
        d.set_item("audio", table(py, sound, frames, channels)?)?;
        let ledger = ["time", "start", "stored", "lost", "made", "work", "changed", "residual", "peak"];
        d.set_item("energy", columns(py, &ledger, &energy)?)?;
        let numbers = [
            "time",
            "frames",
            "missed",
            "stale",
            "dropped",
            "faults",
            "clipped",
            "late_p50",
            "late_p99",
            "late_max",
            "busy",
            "underruns",
        ];
        d.set_item("realtime", columns(py, &numbers, &rt)?)?;
        d.set_item("seconds", summary.seconds)?;
        let faults = summary.faults.iter().map(|f| (f.device.clone(), f.time, f.cause.name()));
        d.set_item("faults", faults.collect::<Vec<_>>())?;
        d.set_item("lost", summary.lost)?;
        d.set_item("cut", summary.end.early().map(|(why, _)| why))?;
        Ok(d)
    }

    /// Page with a film of it: see `cordis_anima.Take.view`.
    fn view(&self, py: Python) -> PyResult<String> {
        let take = self.take.clone();
        run_detached(py, None, move |_| ca_film::take(&take, &catalog()))?.map_err(|e| failure(py, e))
    }

    /// Replays it. Returns what was compared, and the first difference.
    fn replay<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let take = self.take.clone();
        let run = move |wanted: &CallProgress| {
            let stopped = || FileError::new(FileErrorKind::Io, "stopped");
            let mut replay = Replay::new(&take, &catalog())?;
            replay.run(&take, &mut |_| (), &mut |_| if wanted.still() { Ok(()) } else { Err(stopped()) })
        };
        let v: ReplayVerdict = run_detached(py, None, run)?.map_err(|e| failure(py, e.into()))?;
        let d = PyDict::new(py);
        d.set_item("identical", v.is_identical())?;
        d.set_item("tolerance", v.tolerance)?;
        d.set_item("forces", v.forces)?;
        d.set_item("samples", v.samples)?;
        d.set_item("hashes", v.hashes)?;
        d.set_item("seconds", v.seconds)?;
        d.set_item("difference", v.difference.map(|d| d.to_string()))?;
        d.set_item("hole", v.hole)?;
        Ok(d)
    }
}
