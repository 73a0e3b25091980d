//! Plays a scene to its end, into arrays.

use crate::compiled::CompiledModel;
use crate::error::{self, failure, usage};
use crate::gesture::Gesture;
use crate::long_call::{CallProgress, run_detached};
use crate::measure::{energy, table};
use ca_core::Ledger;
use ca_io::FileError;
use ca_io::perform::Performance;
use ca_io::sound::Level;
use ca_lab::Failure;
use ca_lab::outcome::Outcome;
use ca_lab::play::{self, BLOCK, Sample};
use numpy::{Element, IntoPyArray as _};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// Outputs of a scene.
struct Rendered<S> {
    frames: u64,
    audio: Vec<S>,
    probes: Vec<f64>,
    level: Level,
    /// Run time \[s\].
    run_time: f64,
    outcome: Outcome,
    /// Energy ledger, and the number of ticks it covers.
    energy: Option<(Ledger, u64)>,
}

/// Reasons for a failed render.
enum NotRendered {
    Gesture(FileError),
    /// This many samples do not fit in memory.
    TooLong(u64),
    Failed(Failure),
}

fn play_to_end<S: Sample>(
    of: &CompiledModel,
    seconds: Option<f64>,
    gesture: Option<&Gesture>,
    wanted: &CallProgress,
) -> Result<Rendered<S>, NotRendered> {
    let (scene, gesture) = (&*of.scene, gesture.map(|g| &g.gesture));
    let performance = Performance::new(scene, gesture).map_err(NotRendered::Gesture)?;
    let length = play::Length::of(&performance, seconds);
    let frames = length.frames;
    let (channels, n_out) = (scene.counts.channels, scene.counts.n_out);
    let (mut audio, mut probes, mut level) = (Vec::<S>::new(), Vec::new(), Level::new(channels));
    let len = |width: usize| usize::try_from(frames).ok().and_then(|n| n.checked_mul(width));
    let fits = len(channels).is_some_and(|n| audio.try_reserve_exact(n).is_ok())
        && len(n_out - channels).is_some_and(|n| probes.try_reserve_exact(n).is_ok());
    if !fits {
        return Err(NotRendered::TooLong(frames));
    }
    let played = play::play(performance, length, BLOCK, &mut |_, rows, done| {
        let (width, first) = (n_out.max(1), audio.len());
        audio.resize(first + rows.len() / width * channels, S::default());
        level.keep_rows(rows, width, &mut audio[first..]);
        if n_out > channels {
            rows.chunks_exact(width).for_each(|row| probes.extend_from_slice(&row[channels..]));
        }
        if wanted.goes_on(done, frames) { Ok(()) } else { Err(Failure::Stopped) }
    });
    let played = played.map_err(NotRendered::Failed)?;
    let outcome = Outcome::of(&played, &level, (scene, &of.found), (&of.loaded, &of.options), gesture);
    let frames = played.frames;
    let (run_time, energy) = (played.wall.as_secs_f64(), played.energy.map(|e| (e, played.energy_ticks)));
    Ok(Rendered { frames, audio, probes, level, run_time, outcome, energy })
}

/// See `cordis_anima.Scene.render`. `S` is the type of samples.
pub fn render<S: Sample + Element + 'static>(
    py: Python<'_>,
    model: Arc<CompiledModel>,
    seconds: Option<f64>,
    gesture: Option<Py<Gesture>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'_, PyDict>> {
    let of = model.clone();
    let rendered =
        run_detached(py, progress, move |wanted| play_to_end::<S>(&of, seconds, gesture.as_ref().map(Py::get), wanted));
    let rendered = rendered?.map_err(|e| match e {
        NotRendered::Gesture(e) => error::gesture(py, &e),
        NotRendered::TooLong(n) => {
            usage(py, &format!("{n} samples do not fit into memory; render less, or play blocks with `Scene.open`"))
        }
        NotRendered::Failed(e) => failure(py, e),
    })?;
    let scene = &*model.scene;
    let (frames, channels) = (rendered.frames as usize, scene.counts.channels);
    let d = PyDict::new(py);
    d.set_item("audio", table(py, rendered.audio, frames, channels)?)?;
    d.set_item("probes", table(py, rendered.probes, frames, scene.counts.n_out - channels)?)?;
    d.set_item("probe_names", scene.names.probe_names.clone())?;
    d.set_item("probe_of", scene.names.probe_of.clone())?;
    let peak = rendered.level.peak.iter().copied().fold(0.0, f64::max);
    d.set_item("gain", (peak > 1.0).then(|| play::gain(peak)))?;
    d.set_item("peak", rendered.level.peak.into_pyarray(py))?;
    d.set_item("clipped", rendered.level.clipped)?;
    d.set_item("non_finite", rendered.level.non_finite)?;
    d.set_item("run_time", rendered.run_time)?;
    d.set_item("status", rendered.outcome.status)?;
    d.set_item("message", rendered.outcome.message)?;
    d.set_item("failed", rendered.outcome.failed)?;
    if let Some((ledger, ticks)) = &rendered.energy {
        d.set_item("energy", energy(py, scene, ledger, *ticks)?)?;
    }
    Ok(d)
}
