//! The output of the sound, which may change while the engine runs.
//!
//! The engine's side of another device is made outside and comes by a ring; the one before goes back by another ring and is freed
//! there, so the engine thread neither allocates nor frees. Without a device the engine follows the clock of the machine.

use super::Follow;
use rtrb::{Consumer, Producer, RingBuffer};

/// Changes that may wait, and devices that may wait to be freed.
const WAITING: usize = 4;

/// The engine's end.
pub struct Outlet {
    now: Option<Box<Follow>>,
    next: Consumer<Option<Box<Follow>>>,
    gone: Producer<Box<Follow>>,
}

/// The other end, which changes it.
pub struct Patch {
    next: Producer<Option<Box<Follow>>>,
    gone: Consumer<Box<Follow>>,
}

/// Both ends; `first` plays from the start.
pub fn outlet(first: Option<Follow>) -> (Outlet, Patch) {
    let (to, next) = RingBuffer::new(WAITING);
    let (gone, back) = RingBuffer::new(WAITING);
    (Outlet { now: first.map(Box::new), next, gone }, Patch { next: to, gone: back })
}

impl Outlet {
    /// The device that plays now.
    pub(in crate::serve) fn now(&mut self) -> Option<&mut Follow> {
        self.now.as_deref_mut()
    }

    /// Takes up what is to play from now on; true where something came.
    pub(in crate::serve) fn turn(&mut self) -> bool {
        if self.gone.slots() == 0 {
            return false;
        }
        let Ok(next) = self.next.pop() else { return false };
        if let Some(before) = core::mem::replace(&mut self.now, next) {
            // there is room: only this thread fills the ring
            let _ = self.gone.push(before);
        }
        true
    }
}

impl Patch {
    /// From the next frame on this plays, or nothing. False where the engine has not taken up the changes before.
    pub fn put(&mut self, next: Option<Follow>) -> bool {
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
        assert!(!outlet.turn());
        outlet.now().unwrap().put(&[0.25; 200]);
        assert!(patch.put(Some(second)) && outlet.turn());
        outlet.now().unwrap().put(&[0.5; 200]);
        let mut out = [0.0; 200];
        first_player.fill(&mut out, 1, 0);
        assert_eq!(out, [0.25; 200]);
        second_player.fill(&mut out, 1, 0);
        assert_eq!(out, [0.5; 200]);
        // none at all, and more than the ring holds
        for _ in 0..WAITING {
            assert!(patch.put(None));
        }
        assert!(!patch.put(None));
        while outlet.turn() {}
        assert!(outlet.now().is_none() && patch.put(None));
        // the one before is freed at the other end, and its player ends
        second_player.fill(&mut out, 1, 0);
        assert_eq!(out[199], 0.0);
    }
}
