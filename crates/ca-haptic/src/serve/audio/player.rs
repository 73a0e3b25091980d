//! The device's side: gives the device the samples that it asks for.
//!
//! A call never waits. Missing sound is replaced by the last sample, fading out, and then by silence. The sound after a
//! gap fades in, but only when most of the lead is available again: a late thread then causes one gap instead of one
//! for each frame. Fading costs one multiplication per sample near a gap; elsewhere samples pass unchanged.

use super::{Call, Counts};
use rtrb::chunks::ChunkError;
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;

/// Duration of a fade \[s\].
const FADE: f64 = 0.001;

/// The device's side. Its methods neither allocate nor lock, and do not call the system.
pub struct Player {
    samples: Consumer<f32>,
    calls: Producer<Call>,
    gaps: Producer<u64>,
    counts: Arc<Counts>,
    /// Channels of the scene.
    channels: usize,
    /// Frames requested, and frames taken.
    asked: u64,
    taken: u64,
    /// Frames beyond the lead plus this number are too old.
    held: u64,
    playing: bool,
    started: bool,
    last: Vec<f32>,
    /// Gains of new sound and of the held frame; one of them is 1 or 0.
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
            // the engine itself fades in at the start
            rise: 1.0,
            fall: 0.0,
            step,
        }
    }

    /// Fills a buffer of `wide` interleaved channels that was requested at `at` \[ns\]. A scene with one channel plays
    /// on the first two channels of the device, one with several on as many.
    pub fn fill(&mut self, out: &mut [f32], wide: usize, at: u64) {
        let frames = out.len() / wide.max(1);
        // checked before samples are counted: at an end detected here, all have been sent
        let over = self.samples.is_abandoned();
        let there = self.skip(self.samples.slots() / self.channels);
        let lead = self.counts.lead.load(Relaxed);
        if !self.playing {
            // three quarters of the lead; the rest is for jitter
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
        // if the ring is full, the next call reports the same
        let _ = self.calls.push(Call { from, frames: frames as u32, taken: self.taken, at });
    }

    /// Skips frames that are too old, and returns the number of the others.
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
            // not reached: `n` frames were counted, and only this side takes any
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

fn spread(from: &[f32], gain: f32, to: &mut [f32]) {
    to.fill(0.0);
    if let [mono] = from {
        to.iter_mut().take(2).for_each(|y| *y = mono * gain);
    } else {
        to.iter_mut().zip(from).for_each(|(y, x)| *y = x * gain);
    }
}
