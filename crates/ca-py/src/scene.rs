//! Scenes: what is compiled, and how it is played to its end.

use crate::error::{self, failure, findings, usage};
use crate::gesture::Gesture;
use crate::gradient::{Energy, Forward, Reverse};
use crate::measure::{energy, table};
use crate::sim::Sim;
use crate::wait::Wait;
use ca_compile::{Compiled, Options};
use ca_core::scene::InputRole;
use ca_io::gesture::PortMap;
use ca_io::perform::Performance;
use ca_io::sound::Level;
use ca_lab::load::{self, Loaded};
use ca_lab::play::{self, BLOCK, Divergence, Sample};
use ca_lab::{Failure, bytes, view};
use ca_model::diag::Diags;
use numpy::{Element, IntoPyArray as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;

/// A compiled model.
#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Scene {
    pub(crate) compiled: Arc<ca_core::Scene>,
    /// of reader and compiler
    found: Diags,
    loaded: Loaded,
    options: Options,
}

impl Scene {
    /// A scene, with what it was compiled from.
    pub fn new(Compiled { scene, findings, .. }: Compiled, loaded: Loaded, options: Options) -> Scene {
        Scene { compiled: Arc::new(scene), found: findings, loaded, options }
    }

    /// What it was compiled from, and how.
    pub fn source(&self) -> (&Loaded, &Options) {
        (&self.loaded, &self.options)
    }

    fn rendered<'py, S: Sample + Element>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (scene, gesture) = (&*self.compiled, gesture.map(|g| &g.gesture));
        let performance = Performance::new(scene, gesture).map_err(|e| error::gesture(py, &e))?;
        let frames = play::frames(scene, play::seconds(&performance, seconds));
        let (channels, n_out) = (scene.channels, scene.n_out);
        let room = |width: usize| usize::try_from(frames).ok().and_then(|n| n.checked_mul(width));
        let mut heard = Heard::<S> { audio: Vec::new(), probes: Vec::new(), level: Level::new(channels) };
        let fits = |n: Option<usize>, reserve: &mut dyn FnMut(usize) -> bool| n.is_some_and(reserve);
        if !fits(room(channels), &mut |n| heard.audio.try_reserve_exact(n).is_ok())
            || !fits(room(n_out - channels), &mut |n| heard.probes.try_reserve_exact(n).is_ok())
        {
            return Err(usage(py, &format!("{frames} samples do not fit into memory; render less, or stream it")));
        }
        let mut wait = Wait::new(progress);
        let played = py.detach(|| {
            play::play(performance, frames, BLOCK, &mut |_, rows, done| {
                let (width, first) = (n_out.max(1), heard.audio.len());
                heard.audio.resize(first + rows.len() / width * channels, S::default());
                heard.level.keep_rows(rows, width, &mut heard.audio[first..]);
                if n_out > channels {
                    rows.chunks_exact(width).for_each(|row| heard.probes.extend_from_slice(&row[channels..]));
                }
                if wait.goes_on(done, frames) { Ok(()) } else { Err(Failure::Stopped) }
            })
        });
        let played = match (wait.error, played) {
            (Some(e), _) => return Err(e),
            (None, played) => played.map_err(|e| failure(py, e))?,
        };
        let divergence = py.detach(|| {
            played.diverged_at?;
            let options = Options { energy: true, probes: Vec::new(), ..self.options.clone() };
            let audited = load::compiled(&self.loaded, &options).0;
            Divergence::of(&played, audited.as_ref().unwrap_or(scene), &self.found, gesture)
        });
        let d = PyDict::new(py);
        d.set_item("audio", table(py, heard.audio, frames as usize, channels)?)?;
        d.set_item("probes", table(py, heard.probes, frames as usize, n_out - channels)?)?;
        d.set_item("probe_names", scene.probe_names.clone())?;
        d.set_item("probe_of", scene.probe_of.clone())?;
        let peak = heard.level.peak.iter().copied().fold(0.0, f64::max);
        d.set_item("gain", (peak > 1.0).then(|| play::gain(peak)))?;
        d.set_item("peak", heard.level.peak.into_pyarray(py))?;
        d.set_item("clipped", heard.level.clipped)?;
        d.set_item("non_finite", heard.level.non_finite)?;
        d.set_item("refused", played.performance.state.refused)?;
        d.set_item("run_time", played.wall.as_secs_f64())?;
        d.set_item("broke", divergence.map(|b| (b.time, b.module.clone(), b.to_string())))?;
        if let Some(ledger) = &played.energy {
            d.set_item("energy", energy(py, scene, ledger, played.energy_ticks)?)?;
        }
        Ok(d)
    }
}

/// What a render is, while it goes on.
struct Heard<S> {
    audio: Vec<S>,
    probes: Vec<f64>,
    level: Level,
}

#[pymethods]
impl Scene {
    /// Rates, names, counts.
    fn about<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let s = &self.compiled;
        let d = PyDict::new(py);
        d.set_item("title", &s.title)?;
        d.set_item("name", &self.loaded.name)?;
        d.set_item("rate", s.rate)?;
        d.set_item("gesture_rate", s.rate / f64::from(s.ratio))?;
        d.set_item("ratio", s.ratio)?;
        d.set_item("oversample", s.oversample())?;
        d.set_item("channels", s.channel_names.clone())?;
        d.set_item("seconds", s.seconds)?;
        d.set_item("n_mat", s.mats())?;
        d.set_item("n_lia", s.lias())?;
        d.set_item("left_out", s.left_out.clone())?;
        let passes = s.reads.iter().chain(s.summed()).chain(&s.writes).chain(&s.moves);
        d.set_item("passes", passes.map(|o| (o.name, s.modules(o))).collect::<Vec<_>>())?;
        Ok(d)
    }

    /// Ports: name, role, rest.
    #[getter]
    fn inputs(&self) -> Vec<(&str, &str, f64)> {
        let role = |r: InputRole| match r {
            InputRole::Position => "position",
            InputRole::Force => "force",
            InputRole::Device => "device",
        };
        self.compiled.inputs.iter().map(|i| (i.name.as_str(), role(i.role), i.rest)).collect()
    }

    /// Live parameters: name, value, least, most, unit, document.
    #[getter]
    fn params(&self) -> Vec<(&str, f64, f64, f64, &str, &str)> {
        let list = self.compiled.live.params.iter();
        list.map(|p| (p.name.as_str(), p.value, p.min, p.max, p.unit.symbol, p.doc.as_str())).collect()
    }

    /// Probes: their names, and for each the selector that asked for it.
    #[getter]
    fn probes(&self) -> (Vec<String>, Vec<u32>) {
        (self.compiled.probe_names.clone(), self.compiled.probe_of.clone())
    }

    /// What names it among machines: the hash of its model's bytes and of its sound rate.
    fn digest(&self, py: Python) -> PyResult<String> {
        let named = bytes::named(&self.loaded, self.compiled.rate).map_err(|e| failure(py, e))?;
        Ok(named.to_hex().to_string())
    }

    /// JSON of what was found, and how it reads.
    fn findings(&self) -> (String, String) {
        findings(&self.found, &self.loaded.model)
    }

    /// What is proven of its stability.
    fn certificate<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let c = &self.compiled.certificate;
        let d = PyDict::new(py);
        d.set_item("level", c.level.to_string())?;
        d.set_item("bound", c.bound)?;
        d.set_item("lower", c.lower)?;
        d.set_item("margin", c.margin())?;
        d.set_item("exact", c.exact)?;
        d.set_item("largest", c.largest)?;
        d.set_item("ripple", c.ripple)?;
        d.set_item("worst", &c.worst)?;
        d.set_item("contact", c.contact)?;
        d.set_item("stiffest", &c.stiffest)?;
        d.set_item("depth", c.depth.clone())?;
        d.set_item("friction", c.friction)?;
        d.set_item("not_judged", c.not_judged.clone())?;
        Ok(d)
    }

    /// Plays it: see `cordis_anima.Scene.render`; `double` says how samples are kept.
    #[pyo3(signature = (seconds, gesture, double, progress))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        double: bool,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let run = if double { Scene::rendered::<f64> } else { Scene::rendered::<f32> };
        run(self, py, seconds, gesture, progress)
    }

    /// With derivatives by parameters of these names.
    fn forward(&self, py: Python, wrt: Vec<String>) -> PyResult<Forward> {
        Forward::new(py, &self.loaded, &self.options, &wrt)
    }

    /// With derivatives of its energy by parameters of these names.
    fn energy_forward(&self, py: Python, wrt: Vec<String>) -> PyResult<Energy> {
        Energy::new(py, &self.loaded, &self.options, &wrt)
    }

    /// To be gone back over, with derivatives by parameters of these names.
    fn reverse(&self, py: Python, wrt: Vec<String>) -> PyResult<Reverse> {
        Reverse::new(py, &self.loaded, &self.options, &wrt)
    }

    /// The page of a film of it: see `cordis_anima.Scene.view`.
    #[pyo3(signature = (seconds, gesture, progress))]
    fn view(
        &self,
        py: Python,
        seconds: Option<f64>,
        gesture: Option<&Gesture>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        // what nothing hears is seen all the same
        let options = Options { whole: true, energy: false, probes: Vec::new(), ..self.options.clone() };
        let whole = load::compiled(&self.loaded, &options).0;
        let (scene, gesture) = (whole.as_ref().unwrap_or(&self.compiled), gesture.map(|g| &g.gesture));
        let mut wait = Wait::new(progress);
        let page = py.detach(|| view::scene(scene, gesture, seconds, &mut |done, all| wait.goes_on(done, all)));
        match (wait.error, page) {
            (Some(e), _) => Err(e),
            (None, page) => page.map_err(|e| failure(py, e)),
        }
    }

    /// From a file: CSV, NPY, WAV, MIDI (by the mappings of its ports) or a take; `port` names its only track, `rate` [Hz] is
    /// that of an array without times.
    fn gesture(&self, py: Python, path: PathBuf, port: Option<String>, rate: Option<f64>) -> PyResult<Gesture> {
        let map = |i: &ca_core::scene::Input| Some(PortMap { port: i.name.clone(), map: i.midi? });
        let ports: Vec<PortMap> = self.compiled.inputs.iter().filter_map(map).collect();
        Gesture::open(py, &path, &ports, port, rate)
    }

    /// A running one.
    fn sim(&self) -> Sim {
        Sim::new(self.compiled.clone())
    }
}
