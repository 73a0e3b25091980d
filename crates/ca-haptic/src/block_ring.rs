//! Passes blocks of numbers of any length through a ring, each whole or not at all.
//!
//! A block is a tick, the number of values, and the values. Neither side allocates once the reader's buffer has grown.

use rtrb::{Consumer, Producer};

/// Writes one block with the values of both slices; returns `false` where the ring lacks capacity for all of it.
pub(crate) fn put(ring: &mut Producer<f64>, tick: u64, values: &[f64], more: &[f64]) -> bool {
    let n = values.len() + more.len();
    match ring.write_chunk_uninit(n + 2) {
        Ok(chunk) => {
            let head = [tick as f64, n as f64];
            chunk.fill_from_iter(head.into_iter().chain(values.iter().copied()).chain(more.iter().copied()));
            true
        }
        Err(_) => false,
    }
}

/// Reads one block into `into` and returns its tick; `None` where the ring is empty.
pub(crate) fn take(ring: &mut Consumer<f64>, into: &mut Vec<f64>) -> Option<u64> {
    let tick = ring.pop().ok()?;
    let n = ring.pop().ok()? as usize;
    let chunk = ring.read_chunk(n).ok()?;
    into.clear();
    into.extend(chunk);
    Some(tick as u64)
}
