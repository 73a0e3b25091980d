//! Plays a scene in memory: the values of its probes at the samples of the model's rate, and the time taken.

use super::Steps;
use ca_core::{Balance, Real, Scene};
use ca_io::perform::Performance;
use ca_io::play::{BLOCK, play};
use ca_io::player::Player;
use ca_lab::Failure;

/// One column per probe.
pub type Columns = Vec<Vec<f64>>;

/// Selects probes and samples from rows of outputs.
#[derive(Clone, Copy)]
pub struct Kept {
    /// Columns before the probes.
    pub channels: usize,
    pub n_out: usize,
    /// Ticks per sample; the first of them is stored.
    pub times: u32,
}

impl Kept {
    /// Allocates empty columns for `frames` samples.
    pub fn columns(self, frames: usize) -> Columns {
        vec![Vec::with_capacity(frames); self.n_out - self.channels]
    }

    /// Stores rows that end at tick `done`; values from tick `known` are NaN.
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

/// Returns the tick from which the output of a player is invalid.
pub fn known<R: Real>(player: &Player<R>) -> u64 {
    if player.diverged { player.state.tick } else { u64::MAX }
}

/// Plays `frames` samples of `times` ticks. Returns the columns (NaN once diverged) and ns per sample.
pub fn columns(scene: &Scene, frames: usize, times: u32, steps: &mut Steps) -> Result<(Columns, f64), Failure> {
    let kept = Kept { channels: scene.counts.channels, n_out: scene.counts.n_out, times };
    let mut all = kept.columns(frames);
    let p = Performance::new(scene, None)?;
    let (clock, begin) = (steps.clock, (steps.clock.now)());
    play(p, frames as u64 * u64::from(times), BLOCK, &mut |p, rows, done| {
        kept.keep(&mut all, rows, done, known(p));
        steps.look()
    })?;
    Ok((all, clock.since(begin) / frames.max(1) as f64))
}

/// Returns the energy ledger after `ticks` ticks, or at the last tick before a divergence.
pub fn ledger(scene: &Scene, ticks: u64) -> Option<Balance> {
    let mut p = Performance::new(scene, None).ok()?;
    p.until(ticks, 1);
    p.player.state.ledger.map(|l| l.balance())
}
