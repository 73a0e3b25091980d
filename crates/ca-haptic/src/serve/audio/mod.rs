//! Sends sound straight to a device that plays it: the ring between engine and device, and the device as a clock.
//!
//! ```text
//! engine thread ── DeviceClock ── samples ─► Player ── callback of the device
//!                        ◄── calls ───
//! ```
//!
//! The two sides share only rings and counters. [`Player`] is called by any player of sound and does not depend on the
//! device. [`DeviceClock`] gives the engine the time at which its next gesture frame is due. Each call of the device reports
//! its position, the samples taken and the time. Nothing else is exchanged, so either side can stall, and the other
//! detects it.

#[cfg(feature = "system")]
mod device_clock;
#[cfg(feature = "system")]
mod dll;
#[cfg(feature = "system")]
mod outlet;
mod outputs;
#[cfg(feature = "system")]
mod player;
#[cfg(all(test, feature = "system"))]
mod tests;

#[cfg(feature = "system")]
pub use device_clock::DeviceClock;
#[cfg(feature = "system")]
pub use dll::Dll;
#[cfg(feature = "system")]
pub use outlet::{Outlet, Patch, outlet};
pub use outputs::{NoChoice, Outputs};
#[cfg(feature = "system")]
pub use player::Player;

use rtrb::Consumer;
#[cfg(feature = "system")]
use rtrb::RingBuffer;
use serde::Serialize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering::Relaxed};

/// One call of the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Call {
    /// First sample requested, counted by the device.
    pub from: u64,
    /// Number of samples requested.
    pub frames: u32,
    /// Samples taken from the engine so far, including this call.
    pub taken: u64,
    /// Time \[ns of [`now_ns`](crate::rt::now_ns)\].
    pub at: u64,
}

/// State shared by both sides and the recorder. Counts are since the start.
#[derive(Debug, Default)]
pub struct Counts {
    /// Times at which there was nothing to play.
    pub underruns: AtomicU64,
    /// Samples of silence played instead.
    pub silent: AtomicU64,
    /// Samples left out because they were too old.
    pub skipped: AtomicU64,
    /// Samples that did not fit because the device did not ask for any.
    pub unheard: AtomicU64,
    /// Underruns reported by the device.
    pub xruns: AtomicU64,
    /// Times at which the device stopped asking.
    pub stops: AtomicU64,
    /// True while the device asks.
    pub alive: AtomicBool,
    /// True once everything is played and nothing follows.
    pub done: AtomicBool,
    /// Rate of the device above nominal \[1e-9\].
    pub ppb: AtomicI64,
    /// Maximum number of frames that the device requested at once.
    pub buffer: AtomicU64,
    /// Time from when a gesture frame is due until its first sample is requested \[samples\].
    pub lead: AtomicU64,
    /// Output latency after a call, as the device reports it \[ns\]; 0 if it does not.
    pub delay: AtomicU64,
}

/// A sound device.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PlaybackDevice {
    /// Sound system through which it plays: `JACK`, `ALSA` …
    pub host: String,
    /// Name.
    pub device: String,
    /// Samples per second.
    pub rate: u32,
    /// Channels that it receives.
    pub channels: u16,
}

/// Summary of a sound device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AudioSummary {
    /// The device.
    #[serde(flatten)]
    pub playback: PlaybackDevice,
    /// Maximum number of frames that it requested at once.
    pub buffer: u64,
    /// Time from when a gesture frame is due until its first sample is requested \[samples\].
    pub lead: u64,
    /// Latency from when a gesture frame is due \[ms\]: the lead, plus one buffer or the reported output latency.
    pub latency_ms: f64,
    /// Times at which there was nothing to play.
    pub underruns: u64,
    /// Samples that came late, of the first underruns.
    pub gaps: Vec<u64>,
    /// Samples of silence played instead.
    pub silent: u64,
    /// Samples left out because they were too old.
    pub skipped: u64,
    /// Samples that did not fit because the device did not ask for any.
    pub unheard: u64,
    /// Underruns reported by the device.
    pub xruns: u64,
    /// Times at which the device stopped asking.
    pub stops: u64,
    /// Deviation of its rate from nominal, by the monotonic clock \[ppm\].
    pub ppm: f64,
}

impl AudioSummary {
    /// Returns true if all sound was played as computed.
    pub fn is_faithful(&self) -> bool {
        self.underruns + self.skipped + self.unheard + self.xruns + self.stops == 0
    }
}

/// The recorder's side.
pub struct Watch {
    /// The sound device.
    pub playback: PlaybackDevice,
    /// Counts of both sides.
    pub counts: Arc<Counts>,
    gaps: Consumer<u64>,
    reported: Vec<u64>,
    /// Gaps before this sample are not reported.
    quiet: u64,
    was_alive: bool,
}

/// Maximum number of gaps that are stored.
const GAPS: usize = 1000;

impl Watch {
    /// Returns messages for people since the last call.
    pub(super) fn take_messages(&mut self) -> Vec<String> {
        let mut messages = Vec::new();
        while let Ok(at) = self.gaps.pop() {
            if self.reported.len() < GAPS {
                self.reported.push(at);
            }
            // one message a second; the summary has all gaps
            if at >= self.quiet {
                self.quiet = at + u64::from(self.playback.rate);
                messages.push(format!("{}: no samples to play at sample {at}", self.playback.host));
            }
        }
        let alive = self.counts.alive.load(Relaxed);
        if alive != self.was_alive {
            let what = if alive {
                "requests sound again"
            } else {
                "no longer requests sound; the engine continues at its last rate; sound returns with the next request"
            };
            // the first start is not reported
            if !alive || self.counts.stops.load(Relaxed) > 0 {
                messages.push(format!("{}: {what}", self.playback.host));
            }
            self.was_alive = alive;
        }
        messages
    }

    /// Returns the summary.
    pub fn summary(&self) -> AudioSummary {
        let c = &self.counts;
        let n = |of: &AtomicU64| of.load(Relaxed);
        let rate = f64::from(self.playback.rate);
        let heard = (n(&c.delay) as f64 * 1e-9).max(n(&c.buffer) as f64 / rate);
        AudioSummary {
            playback: self.playback.clone(),
            buffer: n(&c.buffer),
            lead: n(&c.lead),
            latency_ms: 1e3 * (n(&c.lead) as f64 / rate + heard),
            underruns: n(&c.underruns),
            gaps: self.reported.clone(),
            silent: n(&c.silent),
            skipped: n(&c.skipped),
            unheard: n(&c.unheard),
            xruns: n(&c.xruns),
            stops: n(&c.stops),
            ppm: c.ppb.load(Relaxed) as f64 * 1e-3,
        }
    }
}

/// Delay of a call after which the waiting samples are too old to be played \[s\].
#[cfg(feature = "system")]
const HELD: f64 = 0.1;

/// Makes all three sides, for a scene with `channels` channels and `frame` samples per gesture frame, and for a device
/// that asks for `buffer` samples at once.
#[cfg(feature = "system")]
pub fn link(channels: usize, frame: u32, playback: PlaybackDevice, buffer: u32) -> (DeviceClock, Player, Watch) {
    let counts = Arc::new(Counts::default());
    let rate = f64::from(playback.rate);
    let lead = device_clock::lead(buffer, frame, rate);
    let held = (HELD * rate) as usize;
    let places = 2 * (lead as usize + held) * channels;
    let (samples_in, samples) = RingBuffer::new(places);
    let (calls, calls_out) = RingBuffer::new(1024);
    let (gaps, gaps_out) = RingBuffer::new(GAPS);
    counts.buffer.store(u64::from(buffer), Relaxed);
    counts.lead.store(lead, Relaxed);
    let player = Player::new(channels, rate, held as u64, samples, calls, gaps, counts.clone());
    let follow = DeviceClock::new(channels, frame, rate, buffer, samples_in, calls_out, counts.clone());
    (follow, player, Watch { playback, counts, gaps: gaps_out, reported: Vec::new(), quiet: 0, was_alive: false })
}
