//! The model as written in single precision: the build of the same kernels that `ca-core-single` is.
//!
//! Decides to give it what a gesture gives the scene in double precision, tick by tick and written down beforehand: who
//! moves ports and when is decided in one place, and the time measured is that of the ticks.

use super::Steps;
use super::play::{BLOCK, Columns};
use crate::Failure;
use crate::load::Loaded;
use ca_compile::Options;
use ca_core::Scene;
use ca_core_single as single;
use ca_io::perform::{DIVERGED, Performance};
use ca_model::write::write;
use ca_model_single::diag::Severity;
use std::time::Instant;

/// As people call it.
pub const SINGLE: &str = "single";

/// The scene in single precision, or why there is none.
pub fn compiled(loaded: &Loaded, options: &Options) -> Result<single::Scene, String> {
    let catalog = ca_model_single::catalog();
    let unknown = loaded.model.items.iter().find(|i| catalog.get(&i.kind).is_none() || !loaded.clouds.is_empty());
    if let Some(item) = unknown {
        return Err(format!("`{}` is made in double precision only", item.name));
    }
    let options = ca_compile_single::Options {
        rate: options.rate,
        probes: options.probes.clone(),
        ..ca_compile_single::Options::default()
    };
    let (_, scene) = ca_compile_single::load(&write(&loaded.model), &loaded.model.file, &catalog, &options);
    let scene = scene.map_err(|diags| {
        let first = diags.list.into_iter().find(|d| d.severity == Severity::Error);
        first.map(|d| d.title).unwrap_or_default()
    })?;
    match scene.gestures.iter().find(|(name, _)| scene.input(name).is_none()) {
        Some((name, _)) => Err(format!("a gesture moves `{name}`, which is no port")),
        None => Ok(scene.scene),
    }
}

/// As [`columns`](super::play::columns), of a scene in single precision; `double`, the same in double precision,
/// knows what its ports are given.
pub fn columns(
    scene: &single::Scene,
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
    let mut all = vec![Vec::with_capacity(frames); scene.n_out - scene.channels];
    let mut diverged = false;
    let begin = Instant::now();
    for tick in 0..frames * times as usize {
        if tick % BLOCK == BLOCK - 1 {
            steps.look()?;
        }
        if !diverged {
            s.input.copy_from_slice(&given[tick * n..][..n]);
            single::tick(scene, &mut s);
            diverged = s.tick.is_multiple_of(64) && !s.is_bounded(DIVERGED);
        }
        if tick.is_multiple_of(times as usize) {
            for (column, v) in all.iter_mut().zip(&s.output[scene.channels..]) {
                column.push(if diverged { f64::NAN } else { *v });
            }
        }
    }
    Ok((all, begin.elapsed().as_nanos() as f64 / frames.max(1) as f64))
}
