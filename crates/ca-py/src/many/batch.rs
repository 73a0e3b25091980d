//! Batches: see `cordis_anima.batch`.

use crate::error::failure;
use crate::gesture::Gesture;
use crate::long_call::run_detached;
use crate::model::Given;
use crate::scene::Scene;
use ca_lab::play::Sample;
use ca_sweep::batch::{self, Batch, BatchSpec};
use numpy::{Element, IntoPyArray as _, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Plays a scene once for each set of values. `double` selects double precision for samples.
#[pyfunction]
#[pyo3(name = "batch", signature = (scene, values, seconds, gesture, double, threads, progress))]
#[allow(clippy::too_many_arguments)]
pub fn play(
    py: Python<'_>,
    scene: Py<Scene>,
    values: Vec<(String, Vec<Given>)>,
    seconds: Option<f64>,
    gesture: Option<Py<Gesture>>,
    double: bool,
    threads: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let typed = |all: Vec<Given>| all.into_iter().map(Given::typed).collect();
    let values = values.into_iter().map(|(name, all)| (name, typed(all))).collect();
    let spec = BatchSpec { values, seconds, threads };
    let run = if double { played::<f64> } else { played::<f32> };
    run(py, scene, spec, gesture, progress)
}

fn played<S: Sample + Element + 'static>(
    py: Python<'_>,
    scene: Py<Scene>,
    spec: BatchSpec,
    gesture: Option<Py<Gesture>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let batch = run_detached(py, progress, move |wanted| {
        let (loaded, options) = scene.get().source();
        let gesture = gesture.as_ref().map(|g| &g.get().gesture);
        batch::batch::<S>(loaded, options, &spec, gesture, &mut |done, all| wanted.goes_on(done, all))
    })?;
    let Batch { rate, frames, channels, probes, sound, probed, outcomes, peaks } = batch.map_err(|e| failure(py, e))?;
    let n = outcomes.len();
    let d = PyDict::new(py);
    d.set_item("rate", rate)?;
    d.set_item("audio", sound.into_pyarray(py).reshape([n, frames, channels])?)?;
    d.set_item("probes", probed.into_pyarray(py).reshape([n, frames, probes])?)?;
    d.set_item("peak", peaks.into_pyarray(py))?;
    d.set_item("status", outcomes.iter().map(|o| o.status).collect::<Vec<_>>())?;
    d.set_item("message", outcomes.iter().map(|o| o.message.as_str()).collect::<Vec<_>>())?;
    d.set_item("failed", outcomes.iter().map(|o| o.failed.clone()).collect::<Vec<_>>())?;
    Ok(d)
}
