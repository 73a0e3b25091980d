//! The model as written in single precision: its scene bound to `f32`.
//!
//! Decides to give it what a gesture gives the scene in double precision, tick by tick and written down beforehand: who
//! moves ports and when is decided in one place, and the time measured is that of the ticks.

use super::Steps;
use super::play::{BLOCK, Columns};
use crate::Failure;
use crate::load::Loaded;
use ca_compile::Options;
use ca_core::{Precision, Scene, Unbound};
use ca_io::perform::{DIVERGED, Performance};
use ca_model::diag::Severity;
use std::time::Instant;

/// As people call it.
pub const SINGLE: &str = "single";

/// A scene that was compiled for [`Precision::Single`], bound to it.
///
/// # Errors
/// [`Unbound`].
pub fn bound(scene: &Scene) -> Result<Scene<f32>, Unbound> {
    scene.bind(&cordis_anima::laws())
}

/// The scene in single precision, or why there is none.
pub fn compiled(loaded: &Loaded, options: &Options) -> Result<Scene<f32>, String> {
    let options = Options {
        rate: options.rate,
        probes: options.probes.clone(),
        precision: Precision::Single,
        ..Options::default()
    };
    let scene = loaded.compile(&options).map_err(|found| {
        let first = found.diags.list.into_iter().find(|d| d.severity == Severity::Error);
        first.map(|d| d.title).unwrap_or_default()
    })?;
    match scene.about.gestures.iter().find(|(name, _)| scene.input(name).is_none()) {
        Some((name, _)) => Err(format!("a gesture moves `{name}`, which is no port")),
        None => bound(&scene).map_err(|why| why.to_string()),
    }
}

/// As [`columns`](super::play::columns), of a scene in single precision; `double`, the same in double precision,
/// knows what its ports are given.
pub fn columns(
    scene: &Scene<f32>,
    double: &Scene,
    (frames, times): (usize, u32),
    steps: &mut Steps,
) -> Result<(Columns, f64), Failure> {
    let n = scene.inputs.len();
    let mut given = Vec::new();
    if n > 0 {
        let mut p = Performance::new(double, None)?;
        for _ in 0..frames * times as usize {
            p.tick();
            given.extend_from_slice(&p.state.input);
        }
    }
    let mut s = scene.state();
    let mut all = vec![Vec::with_capacity(frames); scene.counts.n_out - scene.counts.channels];
    let mut diverged = false;
    let begin = Instant::now();
    for tick in 0..frames * times as usize {
        if tick % BLOCK == BLOCK - 1 {
            steps.look()?;
        }
        if !diverged {
            s.input.copy_from_slice(&given[tick * n..][..n]);
            ca_core::tick(scene, &mut s);
            diverged = s.tick.is_multiple_of(64) && !s.is_bounded(DIVERGED);
        }
        if tick.is_multiple_of(times as usize) {
            for (column, v) in all.iter_mut().zip(&s.output[scene.counts.channels..]) {
                column.push(if diverged { f64::NAN } else { *v });
            }
        }
    }
    Ok((all, begin.elapsed().as_nanos() as f64 / frames.max(1) as f64))
}
