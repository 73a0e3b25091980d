//! A scene played in memory: what its probes read at the samples of the model's own rate, and the time it took.

use super::Steps;
use crate::Failure;
use ca_core::{Balance, Scene};
use ca_io::perform::{DIVERGED, Performance};
use std::time::Instant;

/// A column for each probe.
pub type Columns = Vec<Vec<f64>>;

/// Samples between two looks whether to go on.
pub const BLOCK: usize = 4096;

/// Plays `frames` samples of `times` ticks; also the nanoseconds of a sample. What is out of range is NaN.
pub fn columns(scene: &Scene, frames: usize, times: u32, steps: &mut Steps) -> Result<(Columns, f64), Failure> {
    let mut p = Performance::new(scene, None)?;
    let mut all = vec![Vec::with_capacity(frames); scene.counts.n_out - scene.counts.channels];
    let begin = Instant::now();
    for frame in 0..frames {
        if frame % BLOCK == BLOCK - 1 {
            steps.look()?;
        }
        p.tick();
        for (column, v) in all.iter_mut().zip(&p.state.output[scene.counts.channels..]) {
            column.push(if p.diverged { f64::NAN } else { *v });
        }
        for _ in 1..times {
            p.tick();
        }
    }
    Ok((all, begin.elapsed().as_nanos() as f64 / frames.max(1) as f64))
}

/// The energy ledger after so many ticks, or as long as it stays within range.
pub fn ledger(scene: &Scene, ticks: u64) -> Option<Balance> {
    let mut p = Performance::new(scene, None).ok()?;
    while p.state.tick < ticks && p.state.is_bounded(DIVERGED) {
        p.tick();
    }
    p.state.ledger.map(|l| l.balance())
}
