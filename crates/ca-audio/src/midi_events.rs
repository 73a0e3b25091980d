//! Passes MIDI from the callback of a sound server such as JACK through a ring to the thread that plays it.
//!
//! Only channel events pass. An event that does not fit in the ring is dropped whole and counted, because a callback
//! cannot wait. The callback neither allocates nor locks.

use ca_io::live_midi::Cable;
use rtrb::{Consumer, Producer, RingBuffer};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Capacity of the ring \[bytes\]: more than a cable carries in a second.
const WAITING: usize = 4096;
/// Shortest time between two reports of lost events.
const QUIET: Duration = Duration::from_secs(1);

/// Callback's end of the ring.
pub struct EventWriter {
    bytes: Producer<u8>,
    lost: Arc<AtomicU64>,
}

/// Playing thread's end of the ring.
pub struct EventReader {
    name: String,
    bytes: Consumer<u8>,
    cable: Cable,
    lost: Arc<AtomicU64>,
    reported: (u64, Option<Instant>),
}

/// Makes both ends for a port of this name.
pub fn ring(name: String) -> (EventWriter, EventReader) {
    let (writer, bytes) = RingBuffer::new(WAITING);
    let lost = Arc::new(AtomicU64::new(0));
    let reader = EventReader { name, bytes, cable: Cable::default(), lost: lost.clone(), reported: (0, None) };
    (EventWriter { bytes: writer, lost }, reader)
}

impl EventWriter {
    /// Adds one event, with its status byte.
    pub fn push(&mut self, event: &[u8]) {
        let of_channel = event.first().is_some_and(|status| (0x80..0xf0).contains(status));
        if of_channel && self.bytes.push_entire_slice(event).is_err() {
            self.lost.fetch_add(1, Relaxed);
        }
    }
}

impl EventReader {
    /// Returns the name of the port.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Passes the bytes since the last call to `feed`.
    pub fn poll(&mut self, feed: impl FnOnce(&mut Cable, &[u8])) {
        let mut piece = [0; WAITING];
        let (arrived, _) = self.bytes.pop_partial_slice(&mut piece);
        feed(&mut self.cable, arrived);
    }

    /// Returns a report of events lost since the last report.
    pub fn take_warning(&mut self) -> Option<String> {
        let (before, at) = self.reported;
        let lost = self.lost.load(Relaxed);
        if lost == before || at.is_some_and(|at| at.elapsed() < QUIET) {
            return None;
        }
        self.reported = (lost, Some(Instant::now()));
        Some(format!("MIDI: {}: {} events lost: they came faster than they are played", self.name, lost - before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrived(reader: &mut EventReader) -> Vec<u8> {
        let mut all = Vec::new();
        reader.poll(|_, bytes| all.extend(bytes));
        all
    }

    #[test]
    fn events_of_channels_pass_whole_or_are_told() {
        let (mut writer, mut reader) = ring("midi_in".into());
        for event in [&[0x90, 60, 127][..], &[0xf8], &[0xf0, 1, 2, 3, 0xf7], &[60, 0], &[], &[0xc2, 5]] {
            writer.push(event);
        }
        assert_eq!(arrived(&mut reader), [0x90, 60, 127, 0xc2, 5]);
        assert_eq!(reader.take_warning(), None);
        for _ in 0..WAITING / 3 + 2 {
            writer.push(&[0x80, 60, 0]);
        }
        assert_eq!(arrived(&mut reader).len(), WAITING / 3 * 3);
        assert!(reader.take_warning().unwrap().contains("2 events"));
        writer.push(&[0; WAITING + 1]);
        writer.push(&[0x90; WAITING + 1]);
        // not again immediately
        assert_eq!(reader.take_warning(), None);
        assert!(arrived(&mut reader).is_empty());
    }
}
