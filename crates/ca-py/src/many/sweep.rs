//! Sweeps: runs of a scene, for any executor.

use crate::error::{failure, usage};
use crate::gesture::Gesture;
use crate::long_call::{run_detached, run_unless};
use crate::measure::table;
use crate::model::{Given, Model};
use ca_lab::Failure;
use ca_sweep::folder::{self, Folder};
use ca_sweep::{Audio, Axis, Column, SweepSpec};
use numpy::{IntoPyArray as _, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A sweep, ready for any of its runs.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Sweep {
    sweep: ca_sweep::Sweep,
    stop: AtomicBool,
}

/// Values of one parameter: a list, or a range as a tuple of two ends, logarithmic or not, and number of steps. The
/// Python side has checked the tuple.
#[derive(FromPyObject)]
enum Space {
    Range(Given, Given, bool, Option<u64>),
    List(Vec<Given>),
}

impl Space {
    fn axis(self, name: &str) -> Result<Axis, Failure> {
        match self {
            Space::List(values) => Axis::list(name, values.into_iter().map(Given::typed).collect()),
            Space::Range(from, to, log, steps) => Axis::range(name, [from.typed(), to.typed()], log, steps),
        }
    }
}

type Rows<'py> = (Bound<'py, PyDict>, Vec<Bound<'py, PyArray2<f32>>>);

#[pymethods]
impl Sweep {
    #[new]
    #[pyo3(signature = (model, *, rate, vary, runs, seed, seconds, gesture, energy, measure))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python,
        model: &Model,
        rate: Option<f64>,
        vary: Vec<(String, Space)>,
        runs: Option<u64>,
        seed: u64,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        energy: bool,
        measure: bool,
    ) -> PyResult<Sweep> {
        let (whole, gesture) = (model.whole(), gesture.map(|g| g.gesture.clone()));
        let made = run_detached(py, None, move |_| {
            let axes = vary.into_iter().map(|(name, space)| space.axis(&name)).collect::<Result<_, _>>()?;
            let ask = SweepSpec { axes, runs, seed, seconds, rate, energy, measure };
            ca_sweep::Sweep::new(whole, ask, gesture)
        });
        Ok(Sweep { sweep: made?.map_err(|e| failure(py, e))?, stop: AtomicBool::new(false) })
    }

    #[getter]
    fn runs(&self) -> u64 {
        self.sweep.runs()
    }

    #[getter]
    fn channels(&self) -> usize {
        self.sweep.channels()
    }

    /// Sound rate [Hz].
    #[getter]
    fn rate(&self) -> f64 {
        self.sweep.rate()
    }

    /// Hash that identifies its scene on any machine.
    #[getter]
    fn hash(&self) -> String {
        self.sweep.hash()
    }

    /// Names of all columns, and of the columns that are axes.
    #[getter]
    fn columns(&self) -> (Vec<String>, Vec<String>) {
        let all = self.sweep.table(&[]).columns.into_iter().map(|c| c.0).collect();
        (all, self.sweep.spec().axes.iter().map(ca_sweep::column).collect())
    }

    /// Text that describes it: equal for equal sweeps only.
    fn reported(&self, audio: &str, chunk: u64) -> String {
        folder::text(&self.sweep, audio, chunk)
    }

    /// Default number of runs per chunk.
    #[getter]
    fn chunk(&self) -> u64 {
        folder::chunk(self.sweep.runs())
    }

    /// Stops running calls in other threads soon.
    fn stop(&self) {
        self.stop.store(true, Relaxed);
    }

    /// Plays runs from `first` up to `end`. Returns columns, and sounds if `audio`.
    fn play(of: Py<Sweep>, py: Python<'_>, first: u64, end: u64, audio: bool) -> PyResult<Rows<'_>> {
        let (rows, sounds) = Sweep::until_stopped(&of, py, move |sweep, goes_on| {
            let (mut rows, mut sounds) = (Vec::new(), Vec::new());
            for index in first..end.min(sweep.runs()) {
                let (row, sound) = sweep.run(index, goes_on)?;
                if audio {
                    sounds.push((sound, row.frames as usize));
                }
                rows.push(row);
            }
            Ok((rows, sounds))
        })?;
        let sweep = &of.get().sweep;
        let sounds = sounds.into_iter().map(|(sound, frames)| table(py, sound, frames, sweep.channels()));
        Ok((columns(py, sweep.table(&rows))?, sounds.collect::<PyResult<_>>()?))
    }

    /// Numbers of the chunks missing in a folder.
    fn missing(&self, py: Python, path: PathBuf, audio: &str, chunk: u64) -> PyResult<Vec<u64>> {
        let folder = self.folder(py, path, audio, chunk)?;
        Ok((0..folder.chunks()).filter(|c| !folder.has(*c)).collect())
    }

    /// Plays a chunk into a folder and returns its number of runs.
    fn fill(of: Py<Sweep>, py: Python, path: PathBuf, audio: &str, chunk: u64, which: u64) -> PyResult<u64> {
        let folder = of.get().folder(py, path, audio, chunk)?;
        let (first, end) = folder.span(which);
        Sweep::until_stopped(&of, py, move |sweep, goes_on| folder.fill(sweep, which, &mut |_| goes_on()))?;
        Ok(end - first)
    }

    /// Writes the manifest of a folder and returns all columns, or `None` if chunks are missing.
    fn gather<'py>(
        of: Py<Sweep>,
        py: Python<'py>,
        path: PathBuf,
        audio: &str,
        chunk: u64,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let folder = of.get().folder(py, path, audio, chunk)?;
        let all = run_detached(py, None, move |_| folder.gather(&of.get().sweep))?.map_err(|e| failure(py, e))?;
        all.map(|t| columns(py, t)).transpose()
    }
}

impl Sweep {
    /// Runs `work` until a signal arrives or [`Sweep::stop`] is called.
    fn until_stopped<R: Send + 'static>(
        of: &Py<Sweep>,
        py: Python,
        work: impl FnOnce(&ca_sweep::Sweep, &mut dyn FnMut() -> bool) -> Result<R, Failure> + Send + 'static,
    ) -> PyResult<R> {
        let mine = of.clone_ref(py);
        let ended = || of.get().stop.load(Relaxed);
        let found = run_unless(py, None, ended, move |wanted| work(&mine.get().sweep, &mut || wanted.still()))?;
        found.unwrap_or(Err(Failure::Stopped)).map_err(|e| failure(py, e))
    }

    fn folder(&self, py: Python, path: PathBuf, audio: &str, chunk: u64) -> PyResult<Folder> {
        let audio = Audio::named(audio);
        let audio = audio.ok_or_else(|| usage(py, "`audio` must be \"flac\", \"wav\" or \"none\" for a folder"))?;
        Folder::open(&path, &self.sweep, audio, chunk).map_err(|e| failure(py, e))
    }
}

/// Numbers as arrays, with NaN for missing ones; texts as lists.
fn columns(py: Python<'_>, table: ca_sweep::RunTable) -> PyResult<Bound<'_, PyDict>> {
    let all = PyDict::new(py);
    for (name, column) in table.columns {
        match column {
            Column::Whole(v) => all.set_item(name, v.into_pyarray(py))?,
            Column::Number(v) => {
                let numbers: Vec<f64> = v.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect();
                all.set_item(name, numbers.into_pyarray(py))?;
            }
            Column::Text(v) => all.set_item(name, v)?,
        }
    }
    Ok(all)
}
