//! The engine thread: rings in, rings out, and the wait between.
//!
//! Decides that this loop calls the kernel for nothing but its wait. What does not fit a ring is counted; what must be
//! freed travels to the desk, and waits here until there is room.

use super::clock::{Clock, Pace, Start, wait_for};
use crate::engine::{Act, Engine};
use crate::frame::{DeviceFrame, ForceFrame};
use crate::guard::Order;
use crate::record::Record;
use crate::rt::now_ns;
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// The engine's ends of the rings.
pub struct Rings {
    /// frames of devices, by number
    pub frames: Consumer<(u32, DeviceFrame)>,
    /// frames of forces, by number
    pub forces: Producer<(u32, ForceFrame)>,
    /// what is asked
    pub acts: Consumer<Act>,
    /// what happened
    pub records: Producer<Record>,
    /// sound, interleaved
    pub sound: Producer<f64>,
    /// how each frame went
    pub beats: Producer<Beat>,
    /// pictures: positions \[m\] of all places, the tick before them; none where nobody looks
    pub views: Option<Producer<f64>>,
}

/// How a gesture frame went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Beat {
    /// when it began, and what was left out
    pub start: Start,
    /// how long it computed \[ns\]
    pub took: u64,
}

/// What both sides may look at while it runs.
#[derive(Debug, Default)]
pub struct Shared {
    /// asks all threads to end
    pub stop: AtomicBool,
    /// force frames the gateway did not fetch in time
    pub lost_forces: AtomicU64,
    /// records nobody fetched in time
    pub lost_records: AtomicU64,
    /// sound samples nobody fetched in time
    pub lost_sound: AtomicU64,
    /// pictures nobody fetched in time
    pub lost_views: AtomicU64,
    /// device frames the input checks dropped
    pub dropped: AtomicU64,
    /// the model has blown up
    pub wild: AtomicBool,
}

/// An engine with its rings, to be moved into its thread.
pub struct Live {
    engine: Engine,
    rings: Rings,
    shared: Arc<Shared>,
    clock: Clock,
    /// frames between two records of energy, pictures and hashes; 0 for none
    every: Every,
    /// a record that found no room and must not be freed here
    waiting: Option<Record>,
}

/// How often things are recorded, in gesture frames; 0 for never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Every {
    /// the energy book, where the scene keeps one
    pub energy: u64,
    /// pictures
    pub view: u64,
    /// hashes of the state
    pub hash: u64,
}

impl Live {
    /// Ready to run.
    pub fn new(engine: Engine, rings: Rings, shared: Arc<Shared>, clock: Clock, every: Every) -> Live {
        Live { engine, rings, shared, clock, every, waiting: None }
    }

    /// Runs until [`Shared::stop`], or `frames` gesture frames. Gives the engine back.
    pub fn run(mut self, frames: Option<u64>) -> Engine {
        let scene = &self.engine.scene;
        let mut pace = Pace::new(f64::from(scene.ratio) * scene.te);
        let mut left = frames;
        while left != Some(0) {
            let start = match self.clock {
                Clock::Monotonic => pace.next(),
                Clock::Device { patience } => {
                    let (frames, stop) = (&self.rings.frames, &self.shared.stop);
                    wait_for(patience, || frames.slots() > 0 || stop.load(Relaxed))
                }
            };
            if self.shared.stop.load(Relaxed) {
                break;
            }
            let begin = now_ns();
            self.frame();
            let _ = self.rings.beats.push(Beat { start, took: now_ns() - begin });
            left = left.map(|n| n - 1);
        }
        // the last word is that forces are off, not silence until the device notices
        self.engine.act(Act::Order(None, Order::Disarm));
        self.keep(Record::Order { tick: self.engine.due(), port: None, order: Order::Disarm });
        self.frame();
        self.engine
    }

    /// One gesture frame.
    pub fn frame(&mut self) {
        self.acts();
        self.devices();
        for (k, out) in self.engine.answer().enumerate() {
            let port = k as u32;
            if self.rings.forces.push((port, *out)).is_err() {
                self.shared.lost_forces.fetch_add(1, Relaxed);
            }
            if self.rings.records.push(Record::Force { port, frame: *out }).is_err() {
                self.shared.lost_records.fetch_add(1, Relaxed);
            }
        }
        let sound = self.engine.finish();
        let lost = match self.rings.sound.write_chunk_uninit(sound.len()) {
            Ok(chunk) => {
                chunk.fill_from_iter(sound.iter().copied());
                0
            }
            Err(_) => sound.len() as u64,
        };
        if lost > 0 {
            self.shared.lost_sound.fetch_add(lost, Relaxed);
        }
        if self.engine.is_wild() {
            self.shared.wild.store(true, Relaxed);
        }
        self.shared.dropped.store(self.engine.counts.dropped, Relaxed);
        self.regular();
    }

    fn acts(&mut self) {
        if let Some(record) = self.waiting.take() {
            self.keep(record);
        }
        while self.waiting.is_none() {
            let Ok(act) = self.rings.acts.pop() else { return };
            let tick = self.engine.due();
            if let Act::Order(port, order) = act {
                self.keep(Record::Order { tick, port, order });
            }
            if matches!(act, Act::Reload(_)) {
                self.shared.wild.store(false, Relaxed);
            }
            if let Some(spent) = self.engine.act(act) {
                self.keep(Record::Spent { tick, spent });
            }
        }
    }

    /// Hands over what must not be lost.
    fn keep(&mut self, record: Record) {
        if let Err(rtrb::PushError::Full(record)) = self.rings.records.push(record) {
            self.waiting = Some(record);
        }
    }

    fn devices(&mut self) {
        while let Ok((port, mut frame)) = self.rings.frames.pop() {
            self.engine.take(port as usize, &mut frame);
            if self.rings.records.push(Record::Device { port, frame }).is_err() {
                self.shared.lost_records.fetch_add(1, Relaxed);
            }
            // one frame of the engine for each of the first device: the next one waits for its own
            if port == 0 && matches!(self.clock, Clock::Device { .. }) {
                return;
            }
        }
    }

    /// What is recorded every so many frames.
    fn regular(&mut self) {
        let (e, n) = (&self.engine, self.engine.counts.frames);
        let due = |every: u64| every > 0 && n.is_multiple_of(every);
        let tick = e.state.tick;
        let energy = due(self.every.energy).then_some(e.state.ledger.as_ref()).flatten();
        let energy = energy.map(|l| Record::Energy { tick, balance: l.balance() });
        let hash = due(self.every.hash).then(|| Record::Hash { tick, bits: e.state.bits() });
        for record in [energy, hash].into_iter().flatten() {
            if self.rings.records.push(record).is_err() {
                self.shared.lost_records.fetch_add(1, Relaxed);
            }
        }
        if let Some(views) = self.rings.views.as_mut().filter(|_| due(self.every.view)) {
            let x = &self.engine.state.x;
            match views.write_chunk_uninit(x.len() + 1) {
                Ok(chunk) => {
                    chunk.fill_from_iter(std::iter::once(tick as f64).chain(x.iter().copied()));
                }
                Err(_) => {
                    self.shared.lost_views.fetch_add(1, Relaxed);
                }
            }
        }
    }
}
