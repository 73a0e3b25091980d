//! Numbers of any length through a ring: a tick, how many, and they, all or nothing. Neither side allocates, once the
//! buffer of the taking side has grown.

use rtrb::{Consumer, Producer};

/// A tick, how many values there are, and they, in two parts: all or nothing.
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

/// Head and values of one `put`; empty where there is none.
pub(crate) fn take(ring: &mut Consumer<f64>, into: &mut Vec<f64>) -> Option<u64> {
    let tick = ring.pop().ok()?;
    let n = ring.pop().ok()? as usize;
    let chunk = ring.read_chunk(n).ok()?;
    into.clear();
    into.extend(chunk);
    Some(tick as u64)
}
