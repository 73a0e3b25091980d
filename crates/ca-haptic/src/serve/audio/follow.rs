//! The side of the engine: when a gesture frame is due, if the device that plays its sound is the clock.
//!
//! Decides that a frame is due a lead before its first sample is asked for: what the device asks for at once, the frame
//! itself, and a margin. Which of the device's samples that is follows from what it has taken so far, so silence that
//! was played, or sound that was left out, moves it by as much, and the ring holds the same amount whatever happened.
//! Where it holds less, frames come at twice the rate until it is full again, never faster: each is a step of the hand.
//! Where it holds more, at half the rate, never slower: forces do not depend on a sound device, and one that no longer
//! asks is left out; frames go on at the rate it had. One that stood still may ask for all of that time at once: the lead
//! never exceeds half of the ring, or no sound would fit into it any more.

use super::{Call, Counts, Dll};
use crate::rt::{Waits, now_ns};
use crate::serve::Start;
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Room for what makes engine or device late \[s\], at least.
const MARGIN: f64 = 0.001;
/// So long without a call \[ns\], and as many calls' time, and the device is left out.
const PATIENCE: f64 = 1e8;
const CALLS: f64 = 4.0;

/// From when a frame of `frame` samples is due until its first is asked for \[samples\]. A device that asks for much at
/// once is one that need not be quick: half of it is margin.
pub(super) fn lead(buffer: u32, frame: u32, rate: f64) -> u64 {
    u64::from(buffer) + u64::from(frame) + ((MARGIN * rate) as u64).max(u64::from(buffer / 2))
}

/// The engine's end. After it is made nothing allocates or locks.
pub struct Follow {
    samples: Producer<f32>,
    calls: Consumer<Call>,
    counts: Arc<Counts>,
    dll: Dll,
    waits: Waits,
    rate: f64,
    channels: usize,
    /// samples of a gesture frame
    frame: u32,
    buffer: u32,
    lead: u64,
    /// the largest lead: half of what the ring holds
    most: u64,
    /// frames handed over
    sent: u64,
    /// from a sample of ours to that of the device which plays it
    shift: i64,
    /// when the last frame was due, or began where it was too late \[ns\]
    planned: f64,
    /// when the device asked last \[ns\]
    heard: u64,
    alive: bool,
    /// silence in samples that is not counted as periods yet
    left: i64,
}

impl Follow {
    pub(super) fn new(
        channels: usize,
        frame: u32,
        rate: f64,
        buffer: u32,
        samples: Producer<f32>,
        calls: Consumer<Call>,
        counts: Arc<Counts>,
    ) -> Follow {
        let most = (samples.buffer().capacity() / channels.max(1) / 2) as u64;
        Follow {
            samples,
            calls,
            counts,
            dll: Dll::new(rate),
            waits: Waits::default(),
            rate,
            channels,
            frame,
            buffer,
            lead: lead(buffer, frame, rate),
            most,
            sent: 0,
            shift: 0,
            planned: 0.0,
            heard: 0,
            alive: false,
            left: 0,
        }
    }

    /// Waits for the next frame.
    pub(in crate::serve) fn next(&mut self) -> Start {
        self.hear(now_ns());
        let due = self.due();
        let now = self.waits.until(due as u64);
        self.begin(due, now)
    }

    /// Learns what the device did.
    pub(super) fn hear(&mut self, now: u64) {
        let before = self.heard;
        while let Ok(call) = self.calls.pop() {
            self.dll.add(call.from, call.at);
            let shift = (call.from + u64::from(call.frames)) as i64 - call.taken as i64;
            if call.taken > 0 && self.alive {
                self.left += (shift - self.shift).max(0);
            }
            self.shift = shift;
            self.heard = call.at;
            if call.frames > self.buffer {
                self.buffer = call.frames;
                self.lead = lead(self.buffer, self.frame, self.rate).min(self.most);
                self.counts.lead.store(self.lead, Relaxed);
            }
        }
        if self.heard != before {
            self.counts.ppb.store((self.dll.ppm() * 1e3) as i64, Relaxed);
        }
        let patience = PATIENCE.max(CALLS * f64::from(self.buffer) * self.dll.sample());
        let alive = self.dll.is_locked() && (now.saturating_sub(self.heard) as f64) < patience;
        if alive != self.alive {
            self.counts.stops.fetch_add(u64::from(self.alive), Relaxed);
            self.counts.alive.store(alive, Relaxed);
            self.alive = alive;
        }
        if self.planned == 0.0 {
            self.planned = now as f64 - self.period();
        }
    }

    /// A gesture frame \[ns\].
    fn period(&self) -> f64 {
        f64::from(self.frame) * self.dll.sample()
    }

    /// When the next frame is due \[ns\].
    pub(super) fn due(&self) -> f64 {
        let period = self.period();
        if !self.alive {
            return self.planned + period;
        }
        let asked = self.dll.when(self.sent as i64 + self.shift - self.lead as i64);
        asked.clamp(self.planned + 0.5 * period, self.planned + 2.0 * period)
    }

    /// A frame that was `due` begins `now` \[ns\].
    pub(super) fn begin(&mut self, due: f64, now: u64) -> Start {
        let late = (now as f64 - due).max(0.0);
        let period = self.period();
        self.planned = if late < period { due } else { now as f64 };
        let mut missed = self.left / i64::from(self.frame);
        self.left %= i64::from(self.frame);
        if !self.alive {
            missed += (late / period) as i64;
        }
        Start { late: late as u64, missed: missed as u64 }
    }

    /// Hands over sound, interleaved.
    pub(in crate::serve) fn put(&mut self, sound: &[f64]) {
        let frames = (sound.len() / self.channels.max(1)) as u64;
        match self.samples.write_chunk_uninit(sound.len()) {
            Ok(chunk) => {
                chunk.fill_from_iter(sound.iter().map(|x| *x as f32));
                self.sent += frames;
            }
            Err(_) => {
                self.counts.unheard.fetch_add(frames, Relaxed);
            }
        }
    }
}
