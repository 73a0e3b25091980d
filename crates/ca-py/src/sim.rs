//! A scene that runs, block by block or frame by frame: gestures in, sound and forces out.
//!
//! Decides that a block is written into arrays of the caller and that nothing is allocated on the way; device ports are
//! read at the first sample of a gesture frame, as from a device.

use crate::error::{failure, usage};
use ca_core::live::Controls;
use ca_core::{State, advance, sense};
use ca_haptic::perform::WILD;
use ca_haptic::sound::Level;
use ca_lab::Failure;
use numpy::{PyArray1, PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// A running scene.
#[pyclass(module = "cordis_anima._core")]
pub struct Sim {
    scene: Arc<ca_core::Scene>,
    state: State,
    controls: Controls,
    level: Level,
    wild: bool,
}

/// A port whose force is told.
#[derive(Clone, Copy)]
enum Felt {
    /// a position port, by its MAT
    Mat(usize),
    /// a device port, by its border
    Border(usize),
}

impl Sim {
    /// From the beginning.
    pub fn new(scene: Arc<ca_core::Scene>) -> Sim {
        let (state, controls, level) = (scene.state(), scene.controls(), Level::new(scene.channels));
        Sim { scene, state, controls, level, wild: false }
    }

    /// The ports that feel a force, in the order of the inputs.
    fn felt(&self) -> Vec<(usize, Felt)> {
        let s = &self.scene;
        let positions = s.enx.iter().map(|p| (p.input as usize, Felt::Mat(p.mat as usize)));
        let devices = s.tgr.iter().enumerate().map(|(k, p)| (p.input as usize, Felt::Border(k)));
        let mut all: Vec<_> = positions.chain(devices).collect();
        // a port in space has an input for each axis; several MATs of one input do not occur
        all.sort_by_key(|(input, _)| *input);
        all
    }
}

#[pymethods]
impl Sim {
    /// Names of the ports whose forces are told.
    #[getter]
    fn ports(&self) -> Vec<String> {
        self.felt().iter().map(|(input, _)| self.scene.inputs[*input].name.clone()).collect()
    }

    /// Samples so far.
    #[getter]
    fn tick(&self) -> u64 {
        self.state.tick
    }

    /// True once it has blown up: silence from there on.
    #[getter]
    fn wild(&self) -> bool {
        self.wild
    }

    /// Samples cut off at full scale, samples without a value, inputs without a value.
    #[getter]
    fn counts(&self) -> (u64, u64, u64) {
        (self.level.clipped, self.level.non_finite, self.state.refused)
    }

    /// Plays as many samples as `audio` has rows: (n x channels). `inputs` is (n x inputs), or (1 x inputs) for all of
    /// them; `forces` (n x ports) is filled where it is given.
    #[pyo3(signature = (inputs, audio, forces=None))]
    fn step(
        &mut self,
        py: Python,
        inputs: PyReadonlyArray2<f64>,
        mut audio: PyReadwriteArray2<f32>,
        mut forces: Option<PyReadwriteArray2<f64>>,
    ) -> PyResult<()> {
        let felt = self.felt();
        let (n_in, channels) = (self.scene.inputs.len(), self.scene.channels);
        let (n, rows) = (audio.shape()[0], inputs.shape()[0]);
        if audio.shape()[1] != channels || inputs.shape()[1] != n_in || ![1, n].contains(&rows) {
            let what = format!("audio must be (n, {channels}) and inputs (n, {n_in}) or (1, {n_in})");
            return Err(usage(py, &what));
        }
        if forces.as_ref().is_some_and(|f| f.shape() != [n, felt.len()]) {
            return Err(usage(py, &format!("forces must be ({n}, {})", felt.len())));
        }
        // of an array without elements there is no view: its strides say nothing
        let given = (!inputs.is_empty()).then(|| inputs.as_array());
        let mut audio = (!audio.is_empty()).then(|| audio.as_array_mut());
        let mut forces = forces.as_mut().filter(|f| !f.is_empty()).map(|f| f.as_array_mut());
        let Sim { scene, state: s, level, wild, .. } = self;
        py.detach(|| {
            for i in 0..n {
                if *wild {
                    s.output.fill(0.0);
                } else {
                    if let Some(given) = &given {
                        let row = given.row(if rows == 1 { 0 } else { i });
                        s.input.iter_mut().zip(row).for_each(|(to, v)| *to = *v);
                    }
                    sense(scene, s);
                }
                if let Some(audio) = &mut audio {
                    for (k, to) in audio.row_mut(i).iter_mut().enumerate() {
                        *to = level.keep(k, s.output[k]) as f32;
                    }
                }
                if let Some(forces) = &mut forces {
                    for (to, (_, f)) in forces.row_mut(i).iter_mut().zip(&felt) {
                        let force = match *f {
                            Felt::Mat(m) => s.f[m],
                            Felt::Border(k) => s.border[k].force,
                        };
                        *to = if *wild || !force.is_finite() { 0.0 } else { force };
                    }
                }
                if !*wild {
                    advance(scene, s);
                    *wild = s.tick.is_multiple_of(64) && !s.is_sound(WILD);
                }
            }
        });
        Ok(())
    }

    /// Starts to move a live parameter, over so many samples.
    fn set(&mut self, py: Python, name: &str, value: f64, samples: u32) -> PyResult<()> {
        let patch = self.controls.set(name, value).map_err(|e| failure(py, Failure::Usage(e.to_string())))?;
        self.state.apply(&patch, samples.saturating_mul(self.scene.oversample()));
        Ok(())
    }

    /// The present value of a live parameter.
    fn get(&self, py: Python, name: &str) -> PyResult<f64> {
        let found = self.controls.params().iter().find(|p| p.name == name).map(|p| p.value);
        found.ok_or_else(|| usage(py, &format!("`{name}` is not a live parameter")))
    }

    /// Back to the beginning.
    fn reset(&mut self) {
        *self = Sim::new(self.scene.clone());
    }

    /// The energy book, where one is kept.
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let book = self.state.ledger.as_ref();
        book.map(|b| crate::measure::energy(py, &self.scene, b, self.state.tick.saturating_sub(1))).transpose()
    }

    /// Displacements of all places as they are now.
    fn positions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.state.x)
    }
}
