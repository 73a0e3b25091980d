//! Compiled scenes and what they offer.

use crate::compiled::CompiledModel;
use crate::error::{failure, findings};
use crate::gesture::Gesture;
use crate::gradient::{Energy, Forward, Reverse};
use crate::long_call::run_detached;
use crate::render::render;
use crate::sim::Sim;
use ca_compile::{Compiled, Options};
use ca_core::InputRole;
use ca_core::internal::scene::modules;
use ca_io::gesture::PortMap;
use ca_lab::bytes;
use ca_lab::load::{self, Loaded};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Scene(Arc<CompiledModel>);

impl Scene {
    pub fn new(Compiled { scene, findings, .. }: Compiled, loaded: Loaded, options: Options) -> Scene {
        Scene(Arc::new(CompiledModel { scene: Arc::new(scene), found: findings, loaded, options }))
    }

    /// Model and options it was compiled from.
    pub fn source(&self) -> (&Loaded, &Options) {
        (&self.0.loaded, &self.0.options)
    }
}

#[pymethods]
impl Scene {
    /// Rates, names, counts.
    fn about<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let s = &self.0.scene;
        let d = PyDict::new(py);
        d.set_item("title", &s.about.title)?;
        d.set_item("name", &self.0.loaded.name)?;
        d.set_item("rate", s.rate)?;
        d.set_item("gesture_rate", s.rate / f64::from(s.rates.ratio))?;
        d.set_item("ratio", s.rates.ratio)?;
        d.set_item("oversample", s.oversample())?;
        d.set_item("channels", s.names.channel_names.clone())?;
        d.set_item("seconds", s.about.seconds)?;
        d.set_item("n_mat", s.mats())?;
        d.set_item("n_lia", s.lias())?;
        d.set_item("left_out", s.about.left_out.clone())?;
        let passes = s.passes.reads.iter().chain(s.passes.summed()).chain(&s.passes.writes).chain(&s.passes.moves);
        d.set_item("passes", passes.map(|o| (o.name(), modules(s, o))).collect::<Vec<_>>())?;
        Ok(d)
    }

    /// Ports: name, role, rest position.
    #[getter]
    fn inputs(&self) -> Vec<(&str, &str, f64)> {
        let role = |r: InputRole| match r {
            InputRole::Position => "position",
            InputRole::Force => "force",
            InputRole::Device => "device",
        };
        self.0.scene.inputs.iter().map(|i| (i.name.as_str(), role(i.role), i.rest)).collect()
    }

    /// Live parameters: name, value, minimum, maximum, unit, documentation.
    #[getter]
    fn params(&self) -> Vec<(&str, f64, f64, f64, &str, &str)> {
        let list = self.0.scene.live.params.iter();
        list.map(|p| (p.name.as_str(), p.value, p.min, p.max, p.unit.symbol, p.doc.as_str())).collect()
    }

    /// Presets: name, and the values of its live parameters.
    #[getter]
    fn presets(&self) -> Vec<(String, BTreeMap<String, f64>)> {
        let all = self.0.scene.about.presets.iter();
        all.map(|(name, values)| (name.clone(), values.iter().cloned().collect())).collect()
    }

    /// Names of probes, and for each the index of its selector.
    #[getter]
    fn probes(&self) -> (Vec<String>, Vec<u32>) {
        (self.0.scene.names.probe_names.clone(), self.0.scene.names.probe_of.clone())
    }

    /// Hash that identifies it on any machine, from the model's bytes and the sound rate.
    fn digest(&self, py: Python) -> PyResult<String> {
        let of = self.0.clone();
        let named = run_detached(py, None, move |_| bytes::named(&of.loaded, of.scene.rate))?;
        Ok(named.map_err(|e| failure(py, e))?.to_hex().to_string())
    }

    /// Findings as JSON and as text.
    fn findings(&self) -> (String, String) {
        findings(&self.0.found, &self.0.loaded.model)
    }

    /// Stability certificate.
    fn certificate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let c = &self.0.scene.certificate;
        let d = PyDict::new(py);
        d.set_item("level", c.level.to_string())?;
        d.set_item("bound", c.bound)?;
        d.set_item("lower", c.lower)?;
        d.set_item("margin", c.margin())?;
        d.set_item("exact", c.exact)?;
        d.set_item("largest", c.largest)?;
        d.set_item("ripple", c.ripple)?;
        d.set_item("worst", &c.worst)?;
        d.set_item("contact", c.rules.contact)?;
        d.set_item("stiffest", &c.rules.stiffest)?;
        d.set_item("depth", c.rules.depth.clone())?;
        d.set_item("friction", c.rules.friction)?;
        d.set_item("closed", c.rules.closed)?;
        d.set_item("decides", &c.rules.decides)?;
        d.set_item("open", &c.rules.open)?;
        d.set_item("not_judged", c.not_judged.clone())?;
        Ok(d)
    }

    /// Plays it, see `cordis_anima.Scene.render`. `double` selects double precision for samples.
    #[pyo3(signature = (seconds, gesture, double, progress))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
        double: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let run = if double { render::<f64> } else { render::<f32> };
        run(py, self.0.clone(), seconds, gesture, progress)
    }

    /// Prepares forward derivatives by the named parameters.
    fn forward(&self, py: Python, wrt: Vec<String>) -> PyResult<Forward> {
        Forward::new(py, self.0.clone(), wrt)
    }

    /// Prepares forward derivatives of the energy by the named parameters.
    fn energy_forward(&self, py: Python, wrt: Vec<String>) -> PyResult<Energy> {
        Energy::new(py, self.0.clone(), wrt)
    }

    /// Prepares reverse derivatives by the named parameters.
    fn reverse(&self, py: Python, wrt: Vec<String>) -> PyResult<Reverse> {
        Reverse::new(py, self.0.clone(), wrt)
    }

    /// Page with a film of it: see `cordis_anima.Scene.view`.
    #[pyo3(signature = (seconds, gesture, progress))]
    fn view(
        &self,
        py: Python,
        seconds: Option<f64>,
        gesture: Option<Py<Gesture>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let of = self.0.clone();
        let page = run_detached(py, progress, move |wanted| {
            // modules without an output are shown too
            let options = Options { whole: true, energy: false, probes: Vec::new(), ..of.options.clone() };
            let whole = load::compiled(&of.loaded, &options).0;
            let (scene, gesture) = (whole.as_ref().unwrap_or(&of.scene), gesture.as_ref().map(|g| &g.get().gesture));
            ca_film::scene(scene, gesture, seconds, &mut |done, all| wanted.goes_on(done, all))
        });
        page?.map_err(|e| failure(py, e))
    }

    /// Reads a gesture file: CSV, NPY, WAV, MIDI (by the mappings of its ports) or a take. `port` names its only track;
    /// `rate` [Hz] applies to an array without times.
    fn gesture(&self, py: Python, path: PathBuf, port: Option<String>, rate: Option<f64>) -> PyResult<Gesture> {
        let map = |i: &ca_core::Input| Some(PortMap { port: i.name.clone(), map: i.midi? });
        let ports: Vec<PortMap> = self.0.scene.inputs.iter().filter_map(map).collect();
        Gesture::open(py, path, ports, port, rate)
    }

    /// Starts a running scene.
    fn sim(&self) -> Sim {
        Sim::new(self.0.scene.clone())
    }
}
