//! A running scene, block by block or frame by frame: gestures in, sound and forces out.
//!
//! A block is written into arrays of the caller, without allocation. A block shorter than 0.2 ms keeps the interpreter
//! lock; a longer one lets other threads run. Device ports are read at the first sample of a gesture frame, as from a
//! device. Threads that share one wait for each other's blocks.

use crate::error::{failure, usage};
use crate::long_call::SignalCheck;
use ca_io::running::Running;
use ca_lab::Failure;
use ca_lab::outcome::Outcome;
use ca_lab::play::Sample;
use numpy::{Element, PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Instant;

/// Updates of modules between two checks for signals, about a millisecond.
const UPDATES: usize = 1 << 16;

/// Longest block that keeps the interpreter lock \[ns\]. Releasing it costs a wait of about this time for other
/// threads.
const SHORT: u64 = 200_000;

#[pyclass(frozen, module = "cordis_anima._core")]
pub struct Sim {
    scene: Arc<ca_core::Scene>,
    /// Inputs whose forces are reported.
    ports: Vec<usize>,
    running: Mutex<Running>,
    /// Time per sample, as estimated so far \[ns\].
    each: AtomicU64,
}

impl Sim {
    pub fn new(scene: Arc<ca_core::Scene>) -> Sim {
        let running = Running::new(&scene);
        let (ports, running) = (running.force_inputs(), Mutex::new(running));
        Sim { scene, ports, running, each: AtomicU64::new(u64::MAX) }
    }

    /// Runs a short `f` on the running scene. A thread that must wait for it does so without the interpreter lock.
    fn with<R: Send>(&self, py: Python, f: impl FnOnce(&mut Running) -> R + Send) -> R {
        match self.running.try_lock() {
            Ok(mut running) => f(&mut running),
            Err(TryLockError::Poisoned(e)) => f(&mut e.into_inner()),
            Err(TryLockError::WouldBlock) => py.detach(|| f(&mut self.lock())),
        }
    }

    /// Plays `n` samples by `f`, without the interpreter lock unless the block is short.
    fn played(&self, py: Python, n: usize, f: impl FnOnce(&mut Running) + Send) {
        let before = self.each.load(Relaxed);
        let begin = Instant::now();
        if before.saturating_mul(n as u64) < SHORT {
            self.with(py, f);
        } else {
            py.detach(|| f(&mut self.lock()));
        }
        let each = begin.elapsed().as_nanos() as u64 / n.max(1) as u64;
        // limited growth, because an interrupted thread seems slow
        self.each.store(each.min(before.saturating_add(before / 4 + 1)), Relaxed);
    }

    fn lock(&self) -> MutexGuard<'_, Running> {
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn filled<S: Sample + Element>(
        &self,
        py: Python,
        inputs: PyReadonlyArray2<f64>,
        mut audio: PyReadwriteArray2<S>,
        mut forces: Option<PyReadwriteArray2<f64>>,
        mut probes: Option<PyReadwriteArray2<f64>>,
    ) -> PyResult<()> {
        let (scene, ports) = (&*self.scene, &self.ports);
        let (n_in, channels) = (scene.inputs.len(), scene.counts.channels);
        let (n, rows) = (audio.shape()[0], inputs.shape()[0]);
        if audio.shape()[1] != channels || inputs.shape()[1] != n_in || ![1, n].contains(&rows) {
            let what = format!("audio must be (n, {channels}) and inputs (n, {n_in}) or (1, {n_in})");
            return Err(usage(py, &what));
        }
        if forces.as_ref().is_some_and(|f| f.shape() != [n, ports.len()]) {
            return Err(usage(py, &format!("forces must be ({n}, {})", ports.len())));
        }
        let n_probes = scene.counts.n_out - channels;
        if probes.as_ref().is_some_and(|p| p.shape() != [n, n_probes]) {
            return Err(usage(py, &format!("probes must be ({n}, {n_probes})")));
        }
        // an array without elements cannot be viewed, because its strides are meaningless
        let given = (!inputs.is_empty()).then(|| inputs.as_array());
        let mut audio = (!audio.is_empty()).then(|| audio.as_array_mut());
        let mut forces = forces.as_mut().filter(|f| !f.is_empty()).map(|f| f.as_array_mut());
        let mut probes = probes.as_mut().filter(|p| !p.is_empty()).map(|p| p.as_array_mut());
        let every = (UPDATES / (scene.counts.n_mat + scene.counts.n_lia + 1)).clamp(1, 4096);
        let mut look = SignalCheck::new();
        self.played(py, n, |r| {
            for i in 0..n {
                if i % every == every - 1 && !look.goes_on() {
                    return;
                }
                if let Some(given) = &given {
                    let row = given.row(if rows == 1 { 0 } else { i });
                    r.player.state.input.iter_mut().zip(row).for_each(|(to, v)| *to = *v);
                }
                r.player.sense(scene);
                if let Some(audio) = &mut audio {
                    for (k, to) in audio.row_mut(i).iter_mut().enumerate() {
                        *to = S::of(r.level.count(k, r.player.state.output[k]));
                    }
                }
                if let Some(probes) = &mut probes {
                    probes.row_mut(i).iter_mut().zip(&r.player.state.output[channels..]).for_each(|(to, v)| *to = *v);
                }
                if let Some(forces) = &mut forces {
                    for (to, input) in forces.row_mut(i).iter_mut().zip(ports) {
                        *to = r.force(*input);
                    }
                }
                r.player.advance(scene);
            }
        });
        look.error.map_or(Ok(()), Err)
    }
}

/// Output array for sound, in single or double precision.
#[derive(FromPyObject)]
enum Audio<'py> {
    Single(PyReadwriteArray2<'py, f32>),
    Double(PyReadwriteArray2<'py, f64>),
}

#[pymethods]
impl Sim {
    /// Names of the ports whose forces are reported.
    #[getter]
    fn ports(&self) -> Vec<&str> {
        self.ports.iter().map(|input| self.scene.inputs[*input].name.as_str()).collect()
    }

    /// Samples so far.
    #[getter]
    fn tick(&self, py: Python) -> u64 {
        self.with(py, |r| r.player.state.tick)
    }

    /// True once it has diverged; it is silent from then on.
    #[getter]
    fn diverged(&self, py: Python) -> bool {
        self.with(py, |r| r.player.diverged)
    }

    /// Samples clipped at full scale, non-finite samples, non-finite inputs.
    #[getter]
    fn counts(&self, py: Python) -> (u64, u64, u64) {
        self.with(py, |r| (r.level.clipped, r.level.non_finite, r.player.state.ports.refused))
    }

    /// Status of everything played: `ok`, `unstable`, `clipped` or `refused`.
    #[getter]
    fn status(&self, py: Python) -> &'static str {
        self.with(py, |r| {
            if r.player.diverged {
                "unstable"
            } else {
                Outcome::judge(&r.level, r.player.state.ports.refused, true).status
            }
        })
    }

    /// Plays as many samples as `audio` has rows (n x channels). `inputs` is (n x inputs), or (1 x inputs) for all of
    /// them. Fills `forces` (n x ports) and `probes` (n x probes) if given.
    #[pyo3(signature = (inputs, audio, forces=None, probes=None))]
    fn step(
        &self,
        py: Python,
        inputs: PyReadonlyArray2<f64>,
        audio: Audio,
        forces: Option<PyReadwriteArray2<f64>>,
        probes: Option<PyReadwriteArray2<f64>>,
    ) -> PyResult<()> {
        match audio {
            Audio::Single(audio) => self.filled(py, inputs, audio, forces, probes),
            Audio::Double(audio) => self.filled(py, inputs, audio, forces, probes),
        }
    }

    /// Ramps a live parameter to `value` over `samples` samples.
    fn set(&self, py: Python, name: &str, value: f64, samples: u32) -> PyResult<()> {
        let ticks = samples.saturating_mul(self.scene.oversample());
        let done = self.with(py, |r| {
            let patch = r.controls.set(name, value)?;
            r.player.state.apply(&patch, ticks);
            Ok::<(), ca_core::Refused>(())
        });
        done.map_err(|e| failure(py, Failure::Usage(e.to_string())))
    }

    /// Current value of a live parameter.
    fn get(&self, py: Python, name: &str) -> PyResult<f64> {
        let found = self.with(py, |r| r.controls.params().iter().find(|p| p.name == name).map(|p| p.value));
        found.ok_or_else(|| usage(py, &format!("`{name}` is not a live parameter")))
    }

    fn reset(&self, py: Python) {
        self.with(py, |r| *r = Running::new(&self.scene));
    }

    /// The current state as bytes.
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let bytes = self.with(py, |r| r.to_bytes());
        PyBytes::new(py, &bytes)
    }

    /// Continues from the bytes of a state of the same scene.
    fn restore(&self, py: Python, bytes: &[u8]) -> PyResult<()> {
        self.with(py, |r| r.restore(&self.scene, bytes)).map_err(|why| failure(py, Failure::Usage(why.to_string())))
    }

    /// Current value of every input.
    #[getter]
    fn inputs(&self, py: Python) -> Vec<f64> {
        self.with(py, |r| r.player.state.input.clone())
    }

    /// The energy ledger, if it has one.
    fn energy<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let (ledger, tick) = self.with(py, |r| (r.player.state.ledger.clone(), r.player.state.tick));
        ledger.map(|b| crate::measure::energy(py, &self.scene, &b, tick.saturating_sub(1))).transpose()
    }
}
