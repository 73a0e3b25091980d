//! Fits numbers of a model to a recording.

use crate::error::{failure, file};
use crate::gesture::Gesture;
use crate::long_call::run_detached;
use ca_fit::{Distance, FitOptions, Pitch, Range, Stage, StopReason, Words};
use ca_io::recording::Recording;
use ca_lab::Failure;
use ca_lab::load::Loaded;
use ca_model::Value;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;

/// Target of a fit: a file, or samples (frames, channels) at a rate.
#[derive(FromPyObject)]
pub enum Target<'py> {
    /// A WAV or FLAC file.
    File(PathBuf),
    /// Rate \[Hz\] and samples.
    Samples(f64, PyReadonlyArray2<'py, f64>),
}

/// Arguments of a fit.
pub struct FitArgs {
    /// Names of the numbers to fit.
    pub vary: Vec<String>,
    /// Ranges of some of them, in SI units or as text.
    pub ranges: Vec<(String, String, String)>,
    /// Length of sound to fit \[s\].
    pub seconds: Option<f64>,
    /// Fixed gain; fitted if `None`.
    pub gain: Option<f64>,
    /// Largest number of renders.
    pub renders: u32,
    /// Gesture that plays the model.
    pub gesture: Option<Py<Gesture>>,
    /// Path of a report page.
    pub report: Option<PathBuf>,
}

fn distance<'py>(py: Python<'py>, d: &Distance) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item("levels", d.levels)?;
    all.set_item("samples", d.samples)?;
    Ok(all)
}

/// Returns the fitted model, and the other results as a dictionary.
pub fn fitted<'py>(
    py: Python<'py>,
    loaded: Loaded,
    target: Target,
    asked: FitArgs,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Loaded, Bound<'py, PyDict>)> {
    let (recording, name) = match target {
        Target::File(path) => {
            let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            (Recording::open(&path).map_err(|e| file(py, &e))?, name)
        }
        Target::Samples(rate, samples) => {
            let samples = samples.as_array();
            let channels = samples.columns().into_iter().map(|c| c.to_vec()).collect();
            (Recording { rate, channels }, "the recording".to_owned())
        }
    };
    let range = |(name, from, to): &(String, String, String)| Range {
        name: name.clone(),
        ends: [Value::typed(from), Value::typed(to)],
    };
    let ranges: Vec<Range> = asked.ranges.iter().map(range).collect();
    let found = run_detached(py, progress, move |wanted| {
        let mut ask = FitOptions {
            vary: &asked.vary,
            ranges: &ranges,
            seconds: asked.seconds,
            gain: asked.gain,
            renders: asked.renders,
            gesture: asked.gesture.as_ref().map(|g| &g.get().gesture),
            words: &Words::PYTHON,
            progress: &mut |done, of| wanted.goes_on(u64::from(done), u64::from(of)),
        };
        let found = ca_fit::fit(&loaded, &recording, &mut ask)?;
        if let Some(path) = asked.report.as_ref().filter(|_| wanted.still()) {
            let page = ca_fit::report(&found, &loaded.name, &name).html();
            ca_io::atomic_file::write(path, page.as_bytes())?;
        }
        Ok::<_, Failure>(found)
    })?;
    let found = found.map_err(|e| failure(py, e))?;
    let all = PyDict::new(py);
    let numbers = found.fitted.iter();
    let numbers: Vec<_> = numbers
        .map(|f| (f.varied.name.clone(), f.value, f.deviation, f.varied.unit.clone(), f.varied.start, f.at_end))
        .collect();
    all.set_item("numbers", numbers)?;
    all.set_item("gain", found.gain)?;
    all.set_item("delay", found.delay)?;
    all.set_item("renders", found.renders)?;
    all.set_item("seconds", found.seconds)?;
    all.set_item("stage", if found.stage == Stage::Samples { "samples" } else { "levels" })?;
    all.set_item("settled", found.halt == StopReason::Settled)?;
    all.set_item("explained", found.explained && !found.is_elsewhere())?;
    let Pitch { recording, start, found: ends, .. } = found.pitch;
    all.set_item("pitch", (recording, start, ends, found.pitch.starts_far(), found.is_elsewhere()))?;
    all.set_item("warnings", found.warnings())?;
    all.set_item("before", distance(py, &found.before)?)?;
    all.set_item("after", distance(py, &found.after)?)?;
    if let Some(b) = &found.beyond {
        let d = PyDict::new(py);
        d.set_item("seconds", b.seconds)?;
        d.set_item("model", distance(py, &b.model)?)?;
        d.set_item("sinusoids", distance(py, &b.sinusoids)?)?;
        d.set_item("count", b.count)?;
        all.set_item("beyond", d)?;
    }
    Ok((found.loaded, all))
}
