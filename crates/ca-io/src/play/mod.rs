//! Play: the loop that plays a scene to its end without a clock.
//!
//! [`player`] steps a state, [`perform`] applies gestures to it, and [`length`] determines how long it is played. The
//! loop in this module passes on the outputs in blocks and keeps the energy ledger. [`running`] is for a program that
//! drives a scene from outside.

pub mod length;
pub mod perform;
pub mod player;
pub mod running;

use ca_core::Ledger;
use length::Length;
use perform::{DIVERGED, Performance};
use std::time::{Duration, Instant};

/// Ticks per block of outputs.
pub const BLOCK: u64 = 1024;

/// Result of a play.
pub struct Played<'a> {
    /// The performance, at its end.
    pub performance: Performance<'a>,
    /// Samples played.
    pub frames: u64,
    /// Time spent; zero in WebAssembly, where a clock is missing.
    pub wall: Duration,
    /// Tick at which a divergence was found.
    pub diverged_at: Option<u64>,
    /// Ledger at the end, or at the divergence.
    pub energy: Option<Ledger>,
    /// Ticks in the ledger.
    pub energy_ticks: u64,
}

/// Receives the outputs, row by row, and the number of samples so far.
pub type Sink<'a, E> = dyn FnMut(&Performance, &[f64], u64) -> Result<(), E> + 'a;

/// Plays for a length. After every `block` samples, `heard` receives their outputs.
///
/// # Errors
/// The errors of `heard`, which end the play.
pub fn play<'a, E>(
    mut p: Performance<'a>,
    length: impl Into<Length>,
    block: u64,
    heard: &mut Sink<E>,
) -> Result<Played<'a>, E> {
    let mut length = length.into();
    let n_out = p.scene.counts.n_out;
    let mut rows = Vec::with_capacity(block as usize * n_out);
    let mut last_good: Option<(Ledger, u64)> = None;
    let begin = cfg!(not(target_family = "wasm")).then(Instant::now);
    let mut done = 0;
    while done < length.frames {
        let block = block.min(length.frames - done);
        rows.clear();
        if p.state.ledger.is_none() {
            p.ticks(block, &mut rows);
        } else {
            for _ in 0..block {
                keep_ledger(&p, &mut last_good);
                p.tick();
                rows.extend_from_slice(&p.state.output[..n_out]);
            }
        }
        done += block;
        heard(&p, &rows, done)?;
        if !length.add_rows(&rows, n_out, p.scene.counts.channels) {
            break;
        }
    }
    let wall = begin.map_or(Duration::ZERO, |begin| begin.elapsed());
    // finds a divergence since the last check of the state
    p.diverged |= !p.state.is_bounded(DIVERGED);
    let diverged_at = p.diverged.then_some(p.state.tick);
    let (energy, energy_ticks) = match last_good {
        Some((ledger, tick)) => (Some(ledger), tick),
        None => (p.state.ledger.as_deref().cloned(), p.state.tick),
    };
    // a tick is entered when the next one begins
    let energy_ticks = energy_ticks.saturating_sub(1);
    Ok(Played { performance: p, frames: done, wall, diverged_at, energy, energy_ticks })
}

/// Saves the ledger when positions first leave every range.
fn keep_ledger(p: &Performance, last_good: &mut Option<(Ledger, u64)>) {
    if let (Some(ledger), None, false) = (p.state.ledger.as_deref(), &*last_good, p.diverged) {
        if !p.state.is_bounded(DIVERGED) {
            *last_good = Some((ledger.clone(), p.state.tick));
        }
    }
}
