//! The sound output, which may change while the engine runs.
//!
//! The engine's side of a new device is made on another thread and arrives through a ring. The old one returns through
//! a second ring and is freed there, so the engine thread neither allocates nor frees. Without a device, the engine
//! follows the monotonic clock.

use super::DeviceClock;
use rtrb::{Consumer, Producer, RingBuffer};

/// Maximum number of changes that wait, and of devices that wait to be freed.
const WAITING: usize = 4;

/// The engine's side.
pub struct Outlet {
    now: Option<Box<DeviceClock>>,
    next: Consumer<Option<Box<DeviceClock>>>,
    gone: Producer<Box<DeviceClock>>,
}

/// The other side, which changes the device.
pub struct Patch {
    next: Producer<Option<Box<DeviceClock>>>,
    gone: Consumer<Box<DeviceClock>>,
}

/// Makes both sides; `first` plays from the start.
pub fn outlet(first: Option<DeviceClock>) -> (Outlet, Patch) {
    let (to, next) = RingBuffer::new(WAITING);
    let (gone, back) = RingBuffer::new(WAITING);
    (Outlet { now: first.map(Box::new), next, gone }, Patch { next: to, gone: back })
}

impl Outlet {
    pub(in crate::serve) fn now(&mut self) -> Option<&mut DeviceClock> {
        self.now.as_deref_mut()
    }

    /// Applies a waiting change. Returns true if there was one.
    pub(in crate::serve) fn poll(&mut self) -> bool {
        if self.gone.slots() == 0 {
            return false;
        }
        let Ok(next) = self.next.pop() else { return false };
        if let Some(before) = core::mem::replace(&mut self.now, next) {
            // it fits, because only this thread writes to the ring
            let _ = self.gone.push(before);
        }
        true
    }
}

impl Patch {
    /// Sets the device that plays from the next frame on, if any. Returns false if too many earlier changes still wait.
    pub fn put(&mut self, next: Option<DeviceClock>) -> bool {
        while self.gone.pop().is_ok() {}
        self.next.push(next.map(Box::new)).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PlaybackDevice, link};
    use super::*;

    #[test]
    fn what_plays_is_changed_and_what_played_comes_back() {
        let who = || PlaybackDevice { rate: 48_000, channels: 1, ..PlaybackDevice::default() };
        let (first, mut first_player, _) = link(1, 16, who(), 64);
        let (second, mut second_player, _) = link(1, 16, who(), 64);
        let (mut outlet, mut patch) = outlet(Some(first));
        assert!(!outlet.poll());
        outlet.now().unwrap().put(&[0.25; 200]);
        assert!(patch.put(Some(second)) && outlet.poll());
        outlet.now().unwrap().put(&[0.5; 200]);
        let mut out = [0.0; 200];
        first_player.fill(&mut out, 1, 0);
        assert_eq!(out, [0.25; 200]);
        second_player.fill(&mut out, 1, 0);
        assert_eq!(out, [0.5; 200]);
        // no device, and more changes than the ring holds
        for _ in 0..WAITING {
            assert!(patch.put(None));
        }
        assert!(!patch.put(None));
        while outlet.poll() {}
        assert!(outlet.now().is_none() && patch.put(None));
        // the old device is freed on the other side, and its player ends
        second_player.fill(&mut out, 1, 0);
        assert_eq!(out[199], 0.0);
    }
}
