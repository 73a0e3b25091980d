//! Plays the model as written in single precision: its scene bound to `f32`.
//!
//! The scene in double precision supplies the inputs of each tick beforehand. Gestures are thus read in one place, and
//! only ticks are timed.

use super::Steps;
use super::play::{Columns, Kept, known};
use ca_compile::Options;
use ca_core::{Precision, Scene, Unbound};
use ca_io::perform::Performance;
use ca_io::play::BLOCK;
use ca_io::player::Player;
use ca_lab::Failure;
use ca_lab::load::Loaded;
use ca_model::diag::Severity;

pub const SINGLE: &str = "single";

/// Binds a scene that was compiled for [`Precision::Single`].
///
/// # Errors
/// [`Unbound`].
pub fn bound(scene: &Scene) -> Result<Scene<f32>, Unbound> {
    scene.bind(&cordis_anima::laws())
}

/// Compiles the scene in single precision, or returns the reason why that is impossible.
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
        Some((name, _)) => Err(format!("a gesture drives `{name}`, which is not a port")),
        None => bound(&scene).map_err(|why| why.to_string()),
    }
}

/// As [`columns`](super::play::columns), in single precision; the same scene in `double` supplies the inputs.
pub fn columns(
    scene: &Scene<f32>,
    double: &Scene,
    (frames, times): (usize, u32),
    steps: &mut Steps,
) -> Result<(Columns, f64), Failure> {
    let (n, ticks) = (scene.inputs.len(), frames as u64 * u64::from(times));
    let mut given = vec![0.0; ticks as usize * n];
    if n > 0 {
        Performance::new(double, None)?.given(&mut given);
    }
    let mut player = Player::new(scene.state());
    let kept = Kept { channels: scene.counts.channels, n_out: scene.counts.n_out, times };
    let (mut all, mut rows) = (kept.columns(frames), Vec::new());
    let begin = (steps.clock.now)();
    for first in (0..ticks).step_by(BLOCK as usize) {
        let run = BLOCK.min(ticks - first);
        rows.clear();
        if n == 0 {
            player.ticks(scene, run, &mut rows);
        }
        for input in given[first as usize * n..][..run as usize * n].chunks_exact(n.max(1)) {
            player.state.input.copy_from_slice(input);
            player.tick(scene);
            rows.extend_from_slice(&player.state.output[..scene.counts.n_out]);
        }
        kept.keep(&mut all, &rows, first + run, known(&player));
        steps.look()?;
    }
    Ok((all, steps.clock.since(begin) / frames.max(1) as f64))
}
