//! A scene played in memory: what its probes read at the samples of the model's own rate, and the time it took.

use super::Steps;
use ca_core::{Balance, Real, Scene};
use ca_io::perform::Performance;
use ca_io::play::{BLOCK, play};
use ca_io::player::Player;
use ca_lab::Failure;

/// A column for each probe.
pub type Columns = Vec<Vec<f64>>;

/// The place of the probes in a row of outputs, and the rows that are kept.
#[derive(Clone, Copy)]
pub struct Kept {
    /// columns before the probes
    pub channels: usize,
    /// all columns
    pub n_out: usize,
    /// ticks of a sample, which is heard at the first of them
    pub times: u32,
}

impl Kept {
    /// Empty columns with room for `frames` samples.
    pub fn columns(self, frames: usize) -> Columns {
        vec![Vec::with_capacity(frames); self.n_out - self.channels]
    }

    /// Keeps rows that end at tick `done`; from tick `known` on nothing is known.
    pub fn keep(self, all: &mut [Vec<f64>], rows: &[f64], done: u64, known: u64) {
        let width = self.n_out.max(1);
        let first = done - (rows.len() / width) as u64;
        for (row, tick) in rows.chunks_exact(width).zip(first..).filter(|r| r.1.is_multiple_of(self.times.into())) {
            for (column, v) in all.iter_mut().zip(&row[self.channels..]) {
                column.push(if tick + 1 < known { *v } else { f64::NAN });
            }
        }
    }
}

/// The tick from which on nothing is known of what a player gives.
pub fn known<R: Real>(player: &Player<R>) -> u64 {
    if player.diverged { player.state.tick } else { u64::MAX }
}

/// Plays `frames` samples of `times` ticks; also the nanoseconds of a sample. Samples out of range are NaN.
pub fn columns(scene: &Scene, frames: usize, times: u32, steps: &mut Steps) -> Result<(Columns, f64), Failure> {
    let kept = Kept { channels: scene.counts.channels, n_out: scene.counts.n_out, times };
    let mut all = kept.columns(frames);
    let p = Performance::new(scene, None)?;
    let played = play(p, frames as u64 * u64::from(times), BLOCK, &mut |p, rows, done| {
        kept.keep(&mut all, rows, done, known(p));
        steps.look()
    })?;
    Ok((all, played.wall.as_nanos() as f64 / frames.max(1) as f64))
}

/// The energy ledger after `ticks` ticks, or at the last tick within range.
pub fn ledger(scene: &Scene, ticks: u64) -> Option<Balance> {
    let mut p = Performance::new(scene, None).ok()?;
    p.until(ticks, 1);
    p.player.state.ledger.map(|l| l.balance())
}
