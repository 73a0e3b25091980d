//! Play: the loop that plays a scene to its end without a clock.
//!
//! [`player`] steps a state, [`perform`] gives it gestures, [`length`] says how long. The loop here hands out the outputs by blocks, and keeps
//! the energy ledger. [`running`] is for a program that drives a scene from outside.

pub mod length;
pub mod perform;
pub mod player;
pub mod running;

use ca_core::Ledger;
use length::Length;
use perform::{DIVERGED, Performance};
use std::time::{Duration, Instant};

/// Ticks between two looks at what was played.
pub const BLOCK: u64 = 1024;

/// The result of a play.
pub struct Played<'a> {
    /// at its end
    pub performance: Performance<'a>,
    /// samples that were played
    pub frames: u64,
    /// time spent
    pub wall: Duration,
    /// the tick at which it was found to have diverged
    pub diverged_at: Option<u64>,
    /// the ledger at the end, or before anything left its range
    pub energy: Option<Ledger>,
    /// ticks in the ledger
    pub energy_ticks: u64,
}

/// Takes the outputs, rows one after the other, and the number of samples so far.
pub type Sink<'a, E> = dyn FnMut(&Performance, &[f64], u64) -> Result<(), E> + 'a;

/// Plays for a length. After every `block` of samples, `heard` gets their outputs.
///
/// # Errors
/// Those of `heard`, which end it.
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
    let begin = Instant::now();
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
        if !length.hear(&rows, n_out, p.scene.counts.channels) {
            break;
        }
    }
    let wall = begin.elapsed();
    // what diverged between two looks at the state is found here at the latest
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

/// Keeps the ledger as it was when positions left every range.
fn keep_ledger(p: &Performance, last_good: &mut Option<(Ledger, u64)>) {
    if let (Some(ledger), None, false) = (p.state.ledger.as_deref(), &*last_good, p.diverged) {
        if !p.state.is_bounded(DIVERGED) {
            *last_good = Some((ledger.clone(), p.state.tick));
        }
    }
}
