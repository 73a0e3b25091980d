//! The engine's side: determines when a gesture frame is due if the sound device is the clock.
//!
//! A frame is due one lead before its first sample is requested. The lead is the number of samples that the device
//! requests at once, plus the frame itself and a margin. The samples taken so far determine the matching sample of the
//! device. So silence played and sound left out shift it by as much, and the ring always holds the same amount.
//!
//! If the ring holds less, frames come at up to twice the rate until it is full again, never faster, because each frame
//! is a step of the hand. If it holds more, they come at no less than half the rate, because forces must not depend on
//! a sound device. A device that stops asking is ignored, and frames continue at its last rate. After a stall, a device
//! may ask for all of that time at once. So the lead never exceeds half of the ring; otherwise, no sound would fit in
//! it any more.

use super::{Call, Counts, Dll};
use crate::rt::{Waits, now_ns};
use crate::serve::Start;
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Smallest margin for delays of engine and device \[s\].
const MARGIN: f64 = 0.001;
/// Time without a call after which the device is ignored \[ns\], or [`CALLS`] calls if they take longer.
const PATIENCE: f64 = 1e8;
const CALLS: f64 = 4.0;

/// Returns the time from when a frame of `frame` samples is due until its first is requested \[samples\]. Half of a
/// large buffer is margin, because a device with a large buffer need not be fast.
pub(super) fn lead(buffer: u32, frame: u32, rate: f64) -> u64 {
    u64::from(buffer) + u64::from(frame) + ((MARGIN * rate) as u64).max(u64::from(buffer / 2))
}

/// The engine's side. Its methods neither allocate nor lock.
pub struct DeviceClock {
    samples: Producer<f32>,
    calls: Consumer<Call>,
    counts: Arc<Counts>,
    dll: Dll,
    waits: Waits,
    rate: f64,
    channels: usize,
    /// Samples of a gesture frame.
    frame: u32,
    buffer: u32,
    lead: u64,
    /// Largest lead: half of the ring.
    most: u64,
    /// Samples handed over.
    sent: u64,
    /// Offset from a sample of the engine to the sample of the device that plays it.
    shift: i64,
    /// Time at which the last frame was due, or at which it began if it was too late \[ns\].
    planned: f64,
    /// Time of the last call \[ns\].
    heard: u64,
    alive: bool,
    /// Samples of silence not yet counted as periods.
    left: i64,
}

impl DeviceClock {
    pub(super) fn new(
        channels: usize,
        frame: u32,
        rate: f64,
        buffer: u32,
        samples: Producer<f32>,
        calls: Consumer<Call>,
        counts: Arc<Counts>,
    ) -> DeviceClock {
        let most = (samples.buffer().capacity() / channels.max(1) / 2) as u64;
        DeviceClock {
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

    pub(in crate::serve) fn next(&mut self) -> Start {
        self.read_calls(now_ns());
        let due = self.due();
        let now = self.waits.until(due as u64);
        self.begin(due, now)
    }

    /// Reads the calls of the device.
    pub(super) fn read_calls(&mut self, now: u64) {
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

    /// Returns the duration of a gesture frame \[ns\].
    fn period(&self) -> f64 {
        f64::from(self.frame) * self.dll.sample()
    }

    /// Returns when the next frame is due \[ns\].
    pub(super) fn due(&self) -> f64 {
        let period = self.period();
        if !self.alive {
            return self.planned + period;
        }
        let asked = self.dll.when(self.sent as i64 + self.shift - self.lead as i64);
        asked.clamp(self.planned + 0.5 * period, self.planned + 2.0 * period)
    }

    /// Notes that the frame that was `due` begins `now` \[ns\].
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

    /// Hands interleaved sound to the device.
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
