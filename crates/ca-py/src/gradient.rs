//! Derivatives of the sound and the energy of a scene, for `cordis_anima._analysis.gradient`.

use crate::compiled::CompiledModel;
use crate::error;
use crate::gesture::Gesture;
use crate::long_call::run_detached;
use crate::measure::table;
use ca_gradient::{Error, GoesOn};
use ca_lab::Failure;
use numpy::{
    IntoPyArray as _, PyArray1, PyArray2, PyArray3, PyArrayMethods as _, PyReadonlyArray2, PyUntypedArrayMethods as _,
};
use pyo3::prelude::*;
use std::sync::Arc;

/// A scene with forward derivatives.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Forward(Arc<ca_gradient::Forward>);

/// The exception for a derivative that is not available.
fn failure(py: Python, e: Error) -> PyErr {
    match e {
        Error::Refused(what) => error::usage(py, &what),
        Error::Model(found) => error::failure(py, Failure::Found(found)),
        Error::Gesture(e) => error::gesture(py, &e),
        Error::Stopped => error::failure(py, Failure::Stopped),
    }
}

/// Runs `call` until it ends or a signal arrives.
fn waiting<R: Send + 'static>(
    py: Python,
    call: impl FnOnce(GoesOn) -> Result<R, Error> + Send + 'static,
) -> PyResult<R> {
    run_detached(py, None, move |wanted| call(&mut || wanted.still()))?.map_err(|e| failure(py, e))
}

/// A scene with reverse derivatives.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Reverse(Arc<ca_gradient::Reverse>);

/// Checkpoints of a played scene, from which gradients are computed.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Checkpoints {
    kept: Arc<ca_gradient::Checkpoints>,
    ports: usize,
    channels: usize,
}

/// A scene with energy ledger and forward derivatives.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Energy(Arc<ca_gradient::Energy>);

/// Parameters as name, value and unit.
fn about(parameters: &[ca_gradient::Parameter]) -> Vec<(&str, f64, &str)> {
    parameters.iter().map(|p| (p.name.as_str(), p.value, p.unit.as_str())).collect()
}

fn curves(gesture: Option<&Py<Gesture>>) -> Option<&ca_io::gesture::Gesture> {
    gesture.map(|g| &g.get().gesture)
}

/// Plays a sound and returns it as an array (frames, channels).
fn sound(
    py: Python<'_>,
    channels: usize,
    play: impl FnOnce(GoesOn) -> Result<Vec<f64>, Error> + Send + 'static,
) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let all = waiting(py, play)?;
    let frames = all.len() / channels.max(1);
    table(py, all, frames, channels)
}

/// Converts a cotangent to a flat vector (frames x channels).
fn rows(py: Python, cotangent: &PyReadonlyArray2<'_, f64>, channels: usize) -> PyResult<Vec<f64>> {
    if cotangent.shape()[1] != channels {
        let what = format!("the cotangent has the shape {:?}; it must be (frames, {channels})", cotangent.shape());
        return Err(error::usage(py, &what));
    }
    let mut all: Vec<f64> = Vec::new();
    if all.try_reserve_exact(cotangent.len()).is_err() {
        return Err(error::usage(py, "the cotangent does not fit into memory; play fewer seconds"));
    }
    match cotangent.as_slice() {
        Ok(whole) => all.extend_from_slice(whole),
        Err(_) => all.extend(cotangent.as_array().iter()),
    }
    Ok(all)
}

impl Forward {
    /// Prepares derivatives by the named parameters.
    pub fn new(py: Python, of: Arc<CompiledModel>, wrt: Vec<String>) -> PyResult<Forward> {
        let made = waiting(py, move |_| {
            let names: Vec<&str> = wrt.iter().map(String::as_str).collect();
            ca_gradient::Forward::new(&of.loaded, &of.options, &names)
        });
        Ok(Forward(Arc::new(made?)))
    }
}

#[pymethods]
impl Forward {
    /// Parameters: name, value, unit.
    #[getter]
    fn parameters(&self) -> Vec<(&str, f64, &str)> {
        about(self.0.parameters())
    }

    /// The sound in double precision (frames, channels).
    fn audio<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let of = self.0.clone();
        sound(py, self.0.outputs(), move |goes_on| of.output(seconds, curves(gesture.as_ref()), goes_on))
    }

    /// The sound, and its derivatives (frames, channels, parameters).
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn tangents<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>)> {
        let of = self.0.clone();
        let t = waiting(py, move |goes_on| of.tangents(seconds, curves(gesture.as_ref()), goes_on))?;
        let shape = [t.frames, t.outputs, t.parameters.len()];
        let audio = table(py, t.output, t.frames, t.outputs)?;
        Ok((audio, t.tangents.into_pyarray(py).reshape(shape)?))
    }

    /// Gradient of a loss from its cotangent (frames, channels).
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        cotangent: PyReadonlyArray2<'py, f64>,
        gesture: Option<Py<Gesture>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let all = rows(py, &cotangent, self.0.outputs())?;
        let of = self.0.clone();
        let found = waiting(py, move |goes_on| of.gradient(&all, curves(gesture.as_ref()), goes_on))?;
        Ok(found.into_pyarray(py))
    }
}

impl Energy {
    /// Prepares derivatives of the energy by the named parameters.
    pub fn new(py: Python, of: Arc<CompiledModel>, wrt: Vec<String>) -> PyResult<Energy> {
        let made = waiting(py, move |_| {
            let names: Vec<&str> = wrt.iter().map(String::as_str).collect();
            ca_gradient::Energy::new(&of.loaded, &of.options, &names)
        });
        Ok(Energy(Arc::new(made?)))
    }
}

#[pymethods]
impl Energy {
    /// Parameters: name, value, unit.
    #[getter]
    fn parameters(&self) -> Vec<(&str, f64, &str)> {
        about(self.0.parameters())
    }

    /// Times covered by the ledger (instants), accounts (instants, accounts) in the order of `ca_gradient::ACCOUNTS`,
    /// and their derivatives (instants, accounts, parameters).
    #[allow(clippy::type_complexity, reason = "three arrays")]
    fn tangents<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
        instants: usize,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray3<f64>>)> {
        let of = self.0.clone();
        let t = waiting(py, move |goes_on| of.tangents(seconds, curves(gesture.as_ref()), instants, goes_on))?;
        let shape = [t.instants(), ca_gradient::ACCOUNTS.len(), t.parameters.len()];
        let values = table(py, t.values, shape[0], shape[1])?;
        Ok((t.seconds.into_pyarray(py), values, t.tangents.into_pyarray(py).reshape(shape)?))
    }
}

impl Reverse {
    /// Prepares reverse derivatives by the named parameters.
    pub fn new(py: Python, of: Arc<CompiledModel>, wrt: Vec<String>) -> PyResult<Reverse> {
        let made = waiting(py, move |_| {
            let names: Vec<&str> = wrt.iter().map(String::as_str).collect();
            ca_gradient::Reverse::new(&of.loaded, &of.options, &names)
        });
        Ok(Reverse(Arc::new(made?)))
    }
}

#[pymethods]
impl Reverse {
    /// Parameters: name, value, unit.
    #[getter]
    fn parameters(&self) -> Vec<(&str, f64, &str)> {
        about(self.0.parameters())
    }

    /// True if it supports the gesture.
    fn knows(&self, py: Python, gesture: Option<Py<Gesture>>) -> PyResult<bool> {
        self.0.knows(curves(gesture.as_ref())).map_err(|e| failure(py, e))
    }

    /// Names of the ports with derivatives.
    #[getter]
    fn ports(&self) -> Vec<&str> {
        self.0.ports().collect()
    }

    /// Plays the sound in double precision (frames, channels); also returns the checkpoints for a gradient.
    fn play<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Checkpoints)> {
        let of = self.0.clone();
        let mut kept = waiting(py, move |goes_on| of.play(seconds, curves(gesture.as_ref()), goes_on))?;
        let audio = std::mem::take(&mut kept.output);
        let (channels, frames) = (self.0.outputs(), kept.frames());
        let kept = Arc::new(kept);
        Ok((table(py, audio, frames, channels)?, Checkpoints { kept, ports: self.0.ports().count(), channels }))
    }

    /// Gradient of a loss from its cotangent (frames, channels), and derivatives by the inputs of the ports (frames,
    /// ports).
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        cotangent: PyReadonlyArray2<'py, f64>,
        gesture: Option<Py<Gesture>>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
        let all = rows(py, &cotangent, self.0.outputs())?;
        let of = self.0.clone();
        let found = waiting(py, move |goes_on| of.gradient(&all, curves(gesture.as_ref()), goes_on))?;
        let (frames, ports) = (cotangent.shape()[0], self.0.ports().count());
        Ok((found.parameters.into_pyarray(py), table(py, found.inputs, frames, ports)?))
    }
}

#[pymethods]
impl Checkpoints {
    /// As [`Reverse::gradient`], for the sound that was played.
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn gradient<'py>(
        &self,
        py: Python<'py>,
        cotangent: PyReadonlyArray2<'py, f64>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray2<f64>>)> {
        let all = rows(py, &cotangent, self.channels)?;
        let kept = self.kept.clone();
        let found = waiting(py, move |goes_on| kept.gradient(&all, goes_on))?;
        Ok((found.parameters.into_pyarray(py), table(py, found.inputs, self.kept.frames(), self.ports)?))
    }
}
