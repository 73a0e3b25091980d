//! The side of the device: gives what it asks for.
//!
//! Decides that a call never waits: what is missing is the last sample, fading away, then silence; what comes after it
//! fades in, and not before most of the lead is there again: one gap, not one for each frame of a thread that is late.
//! That costs a multiplication a sample near a gap and nothing elsewhere, where samples pass to the bit.

use super::{Call, Counts};
use rtrb::chunks::ChunkError;
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// A fade \[s\].
const FADE: f64 = 0.001;

/// The device's end. After it is made nothing allocates, locks or calls the system.
pub struct Player {
    samples: Consumer<f32>,
    calls: Producer<Call>,
    gaps: Producer<u64>,
    counts: Arc<Counts>,
    /// of the scene
    channels: usize,
    /// frames asked for, and frames taken
    asked: u64,
    taken: u64,
    /// more frames than the lead and these are too old
    held: u64,
    playing: bool,
    started: bool,
    /// the last frame
    last: Vec<f32>,
    /// of what comes, and of what is held; one of them is 1 or 0
    rise: f32,
    fall: f32,
    step: f32,
}

impl Player {
    pub(super) fn new(
        channels: usize,
        rate: f64,
        held: u64,
        samples: Consumer<f32>,
        calls: Producer<Call>,
        gaps: Producer<u64>,
        counts: Arc<Counts>,
    ) -> Player {
        let step = (1.0 / (FADE * rate)) as f32;
        let last = vec![0.0; channels];
        Player {
            samples,
            calls,
            gaps,
            counts,
            channels,
            asked: 0,
            taken: 0,
            held,
            playing: false,
            started: false,
            last,
            // the engine fades in by itself
            rise: 1.0,
            fall: 0.0,
            step,
        }
    }

    /// Fills a buffer of `wide` interleaved channels that was asked for at `at` \[ns\]. One channel of a scene goes to
    /// the first two of the device, several to as many.
    pub fn fill(&mut self, out: &mut [f32], wide: usize, at: u64) {
        let frames = out.len() / wide.max(1);
        // before samples are counted: an end that is seen here has sent all of them
        let over = self.samples.is_abandoned();
        let there = self.skip(self.samples.slots() / self.channels);
        let lead = self.counts.lead.load(Relaxed);
        if !self.playing {
            // most of the lead: what is left of it is for jitter
            self.playing = over || there as u64 * 4 >= lead * 3;
        }
        let n = if self.playing { there.min(frames) } else { 0 };
        let (now, rest) = out.split_at_mut(n * wide.max(1));
        self.play(now, wide, n);
        self.hold(rest, wide);
        if self.started && !over {
            self.account((frames - n) as u64, self.taken + n as u64);
        }
        self.started |= self.playing;
        if over && there <= frames {
            self.counts.done.store(true, Relaxed);
        }
        self.counts.buffer.fetch_max(frames as u64, Relaxed);
        let from = self.asked;
        self.asked += frames as u64;
        self.taken += n as u64;
        // without room the next call tells as much
        let _ = self.calls.push(Call { from, frames: frames as u32, taken: self.taken, at });
    }

    /// Leaves out what is too old, and gives how many frames there are.
    fn skip(&mut self, there: usize) -> usize {
        let lead = self.counts.lead.load(Relaxed);
        if there as u64 <= lead + self.held {
            return there;
        }
        let old = there - lead as usize;
        if let Ok(chunk) = self.samples.read_chunk(old * self.channels) {
            chunk.commit_all();
            self.taken += old as u64;
            self.counts.skipped.fetch_add(old as u64, Relaxed);
            self.rise = 0.0;
        }
        lead as usize
    }

    fn play(&mut self, out: &mut [f32], wide: usize, n: usize) {
        let chunk: Result<_, ChunkError> = self.samples.read_chunk(n * self.channels);
        let Ok(chunk) = chunk else {
            // they were counted; only this side takes any
            out.fill(0.0);
            return;
        };
        let (a, b) = chunk.as_slices();
        let mut all = a.iter().chain(b);
        for frame in out.chunks_exact_mut(wide.max(1)) {
            for (to, x) in self.last.iter_mut().zip(&mut all) {
                *to = if self.rise < 1.0 { x * self.rise } else { *x };
            }
            self.rise = (self.rise + self.step).min(1.0);
            spread(&self.last, 1.0, frame);
        }
        if n > 0 {
            self.fall = 1.0;
        }
        chunk.commit_all();
    }

    fn hold(&mut self, out: &mut [f32], wide: usize) {
        for frame in out.chunks_exact_mut(wide.max(1)) {
            self.fall = (self.fall - self.step).max(0.0);
            spread(&self.last, self.fall, frame);
        }
    }

    fn account(&mut self, missing: u64, next: u64) {
        if missing == 0 {
            return;
        }
        if self.playing {
            self.playing = false;
            self.counts.underruns.fetch_add(1, Relaxed);
            let _ = self.gaps.push(next);
        }
        self.counts.silent.fetch_add(missing, Relaxed);
        self.rise = 0.0;
    }
}

/// One frame of a scene to one of a device.
fn spread(from: &[f32], gain: f32, to: &mut [f32]) {
    to.fill(0.0);
    if let [mono] = from {
        to.iter_mut().take(2).for_each(|y| *y = mono * gain);
    } else {
        to.iter_mut().zip(from).for_each(|(y, x)| *y = x * gain);
    }
}
