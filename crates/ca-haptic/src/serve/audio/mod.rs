//! Sound straight to a device that plays it: the ring between engine and device, and the clock the device is.
//!
//! ```text
//! engine thread ── Follow ── samples ─► Player ── callback of the device
//!                        ◄── calls ───
//! ```
//!
//! Decides that the two sides share rings and counters only. [`Player`] is called by whatever plays sound, and knows no
//! device; [`Follow`] tells the engine when its next gesture frame falls due. Each call of the device says how far it
//! has come, what it took and when; nothing else passes, so that either side can stand still, and the other sees it.

#[cfg(feature = "system")]
mod dll;
#[cfg(feature = "system")]
mod follow;
#[cfg(feature = "system")]
mod outlet;
mod outputs;
#[cfg(feature = "system")]
mod player;
#[cfg(all(test, feature = "system"))]
mod tests;

#[cfg(feature = "system")]
pub use dll::Dll;
#[cfg(feature = "system")]
pub use follow::Follow;
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
    /// first sample it asked for, counted by the device
    pub from: u64,
    /// how many
    pub frames: u32,
    /// samples of the engine that have been taken, after it
    pub taken: u64,
    /// when \[ns of [`now_ns`](crate::rt::now_ns)\]
    pub at: u64,
}

/// What both sides and the recorder may look at. Counts are since the start.
#[derive(Debug, Default)]
pub struct Counts {
    /// times there was nothing to play
    pub underruns: AtomicU64,
    /// samples of silence that were played for it
    pub silent: AtomicU64,
    /// samples that were left out, since they were too old
    pub skipped: AtomicU64,
    /// samples that found no room, since the device did not ask
    pub unheard: AtomicU64,
    /// underruns the device itself reported
    pub xruns: AtomicU64,
    /// times the device stopped asking
    pub stops: AtomicU64,
    /// the device asks
    pub alive: AtomicBool,
    /// all is played, and nothing will come
    pub done: AtomicBool,
    /// how much faster than nominal the device is \[1e-9\]
    pub ppb: AtomicI64,
    /// the most frames the device asked for at once
    pub buffer: AtomicU64,
    /// from when a gesture frame is due until its first sample is asked for \[samples\]
    pub lead: AtomicU64,
    /// from the call until its sound is heard, as the device says \[ns\]; 0 where it does not
    pub delay: AtomicU64,
}

/// The sound device that plays.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PlaybackDevice {
    /// the system that leads to it: `JACK`, `ALSA` …
    pub host: String,
    /// its name
    pub device: String,
    /// samples a second
    pub rate: u32,
    /// channels it is given
    pub channels: u16,
}

/// How it went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AudioSummary {
    /// the device that played
    #[serde(flatten)]
    pub playback: PlaybackDevice,
    /// frames it asks for at once
    pub buffer: u64,
    /// from when a gesture frame is due until its first sample is asked for \[samples\]
    pub lead: u64,
    /// from when a gesture frame is due until it is heard \[ms\]: the lead, and a buffer or what the device says
    pub latency_ms: f64,
    /// times there was nothing to play
    pub underruns: u64,
    /// the first of them: the sample that came late
    pub gaps: Vec<u64>,
    /// samples of silence instead
    pub silent: u64,
    /// samples left out since they were too old
    pub skipped: u64,
    /// samples that found no room since the device did not ask
    pub unheard: u64,
    /// underruns the device reported
    pub xruns: u64,
    /// times the device stopped asking
    pub stops: u64,
    /// its rate against the monotonic clock \[ppm\]
    pub ppm: f64,
}

impl AudioSummary {
    /// True where all was heard as it was computed.
    pub fn is_faithful(&self) -> bool {
        self.underruns + self.skipped + self.unheard + self.xruns + self.stops == 0
    }
}

/// The recorder's end.
pub struct Watch {
    /// the device that plays
    pub playback: PlaybackDevice,
    /// what both sides count
    pub counts: Arc<Counts>,
    gaps: Consumer<u64>,
    reported: Vec<u64>,
    /// gaps before this sample are not reported
    quiet: u64,
    was_alive: bool,
}

/// Gaps whose samples are kept.
const GAPS: usize = 1000;

impl Watch {
    /// What people should know since the last call.
    pub(super) fn news(&mut self) -> Vec<String> {
        let mut news = Vec::new();
        while let Ok(at) = self.gaps.pop() {
            if self.reported.len() < GAPS {
                self.reported.push(at);
            }
            // once a second is enough, the summary has all of them
            if at >= self.quiet {
                self.quiet = at + u64::from(self.playback.rate);
                news.push(format!("{}: nothing to play at sample {at}", self.playback.device));
            }
        }
        let alive = self.counts.alive.load(Relaxed);
        if alive != self.was_alive {
            let what = if alive {
                "asks for sound"
            } else {
                "no longer asks for sound; the engine goes on at its last rate, and is heard again once it asks"
            };
            // that it begins is what everybody expects
            if !alive || self.counts.stops.load(Relaxed) > 0 {
                news.push(format!("{}: {what}", self.playback.host));
            }
            self.was_alive = alive;
        }
        news
    }

    /// The account.
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

/// How late a call may be \[s\] before what waits for it is too old to be played.
#[cfg(feature = "system")]
const HELD: f64 = 0.1;

/// Both sides, and the recorder's: of a scene of so many channels and so many samples a gesture frame, for a device that asks
/// for `buffer` samples at once.
#[cfg(feature = "system")]
pub fn link(channels: usize, frame: u32, playback: PlaybackDevice, buffer: u32) -> (Follow, Player, Watch) {
    let counts = Arc::new(Counts::default());
    let rate = f64::from(playback.rate);
    let lead = follow::lead(buffer, frame, rate);
    let held = (HELD * rate) as usize;
    let places = 2 * (lead as usize + held) * channels;
    let (samples_in, samples) = RingBuffer::new(places);
    let (calls, calls_out) = RingBuffer::new(1024);
    let (gaps, gaps_out) = RingBuffer::new(GAPS);
    counts.buffer.store(u64::from(buffer), Relaxed);
    counts.lead.store(lead, Relaxed);
    let player = Player::new(channels, rate, held as u64, samples, calls, gaps, counts.clone());
    let follow = Follow::new(channels, frame, rate, buffer, samples_in, calls_out, counts.clone());
    (follow, player, Watch { playback, counts, gaps: gaps_out, reported: Vec::new(), quiet: 0, was_alive: false })
}
