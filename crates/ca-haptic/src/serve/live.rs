//! The engine thread: rings in, rings out, and the wait between.
//!
//! Decides that this loop calls the kernel for nothing but its wait. What does not fit a ring is counted; what must be
//! freed travels to the recorder, and waits here until there is room.

#[cfg(feature = "system")]
use super::audio::Outlet;
use super::clock::{Clock, Start};
#[cfg(feature = "system")]
use super::clock::{Pace, wait_for};
use crate::blocks::put;
use crate::engine::{Engine, EngineCommand, Retired};
use crate::frame::{Cause, DeviceFrame, ForceFrame, Mode};
use crate::guard::Order;
use crate::guard::wait::Wait;
use crate::record::Record;
#[cfg(feature = "system")]
use crate::rt::Waits;
use crate::time::now_ns;
use rtrb::{Consumer, Producer};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Acquire, Ordering::Relaxed};

/// The engine's ends of the rings.
pub struct Rings {
    /// frames of devices, by number
    pub frames: Consumer<(u32, DeviceFrame)>,
    /// frames of forces, by number
    pub forces: Producer<(u32, ForceFrame)>,
    /// what is asked, and how many disarms were asked for before
    pub commands: Consumer<(u64, EngineCommand)>,
    /// what happened
    pub records: Producer<Record>,
    /// sound of a gesture frame: its first tick, how many samples, and they, interleaved
    pub sound: Producer<f64>,
    /// how each frame went
    pub timings: Producer<FrameTiming>,
    /// pictures: a tick, how many places, and their displacements \[m\]; none where nobody looks
    pub views: Option<Producer<f64>>,
    /// plays the sound at once, besides files
    #[cfg(feature = "system")]
    pub audio: Option<Outlet>,
}

/// How a gesture frame went.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTiming {
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
    /// devices whose forces are to be off with the next frame, a bit each: no ring that is full stands in its way
    pub disarm: AtomicU64,
    /// how often that was asked: arming that was asked for before is void
    pub disarms: AtomicU64,
    /// periods left out
    pub missed: AtomicU64,
    /// timings nobody fetched in time
    pub lost_timings: AtomicU64,
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
    /// gesture frames without news of a device that was there
    pub stale: AtomicU64,
    /// sound samples at the peak limit
    pub clipped: AtomicU64,
    /// the model has diverged
    pub diverged: AtomicBool,
}

impl Shared {
    /// Records, sound samples and pictures that found no room on their way to the recorder.
    pub fn lost(&self) -> [u64; 3] {
        [&self.lost_records, &self.lost_sound, &self.lost_views].map(|n| n.load(Relaxed))
    }
}

/// An engine with its rings, to be moved into its thread.
pub struct Live {
    engine: Engine,
    rings: Rings,
    shared: Arc<Shared>,
    clock: Clock,
    /// frames between two records of energy, pictures and hashes; 0 for none
    every: RecordIntervals,
    /// a record that found no room and must not be freed here
    waiting: Option<Record>,
    /// records lost since the last one that found room
    missing: u64,
    /// frames between two looks at what an armed device waits for
    waits: u64,
}

/// Between two looks at what an armed device waits for \[s\].
const WAITS: f64 = 0.25;

/// Places of the ring that frames leave to what is asked of the engine, which is rare and decides its future.
const KEPT: usize = 64;

/// How often things are recorded, in gesture frames; 0 for never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordIntervals {
    /// the energy ledger, where the scene keeps one
    pub energy: u64,
    /// pictures
    pub view: u64,
    /// hashes of the state
    pub hash: u64,
}

impl Live {
    /// Ready to run.
    pub fn new(engine: Engine, rings: Rings, shared: Arc<Shared>, clock: Clock, every: RecordIntervals) -> Live {
        let waits = (WAITS * engine.scene.rate / f64::from(engine.scene.rates.ratio)).max(1.0) as u64;
        Live { engine, rings, shared, clock, every, waiting: None, missing: 0, waits }
    }

    /// Runs until [`Shared::stop`], or `frames` gesture frames; on the clock of a device the time in which none came
    /// counts as well. Gives the engine back.
    #[cfg(feature = "system")]
    pub fn run(mut self, frames: Option<u64>) -> Engine {
        let scene = &self.engine.scene;
        let period = f64::from(scene.rates.ratio) * scene.rates.sample_dt;
        let (mut pace, mut waits) = (Pace::new(period), Waits::default());
        // on the clock of a device no time is due: what tells of a stall is how long nobody looked
        let (mut left, mut looked) = (frames, now_ns());
        while left != Some(0) {
            let mut blind = 0;
            if self.rings.audio.as_mut().is_some_and(Outlet::turn) {
                // time begins anew on another clock
                pace = Pace::new(period);
            }
            let start = match (self.clock, self.rings.audio.as_mut().and_then(Outlet::now)) {
                (Clock::Audio, Some(audio)) => audio.next(),
                (Clock::Monotonic | Clock::Audio, _) => pace.next(),
                (Clock::Device { patience }, _) => {
                    let (frames, stop) = (&self.rings.frames, &self.shared.stop);
                    let ready = || {
                        let now = now_ns();
                        (blind, looked) = (blind.max(now - looked), now);
                        frames.slots() > 0 || stop.load(Relaxed)
                    };
                    wait_for(&mut waits, patience, period * 1e9, ready)
                }
            };
            if self.shared.stop.load(Relaxed) {
                break;
            }
            let begin = now_ns();
            self.lapsed(start.late.max(blind), self.engine.due());
            self.frame();
            self.shared.missed.fetch_add(start.missed, Relaxed);
            self.timed(FrameTiming { start, took: now_ns() - begin });
            looked = now_ns();
            let alone = if matches!(self.clock, Clock::Device { .. }) { start.missed } else { 0 };
            left = left.map(|n| n.saturating_sub(alone.max(1)));
        }
        // the last word is that forces are off, not silence until the device notices
        self.engine.command(EngineCommand::Order(None, Order::Disarm));
        self.keep(Record::Order { tick: self.engine.due(), port: None, order: Order::Disarm });
        self.frame();
        if self.waiting.is_some() {
            self.shared.lost_records.fetch_add(1, Relaxed);
        }
        self.engine
    }

    /// A frame that is so late \[ns\] that the device let go of the last force: it does not come back in one step.
    fn lapsed(&mut self, late: u64, tick: u64) {
        for k in 0..self.engine.ports.len() {
            let p = &self.engine.ports[k];
            let gives = matches!(p.hand.mode, Mode::Ramp | Mode::On | Mode::Damp);
            if gives && late >= u64::from(p.out.ttl_us) * 1000 {
                self.order(k as u32, Order::Trip(Cause::WatchdogOut), tick);
            }
        }
    }

    /// An order that is obeyed at once; only what tells of it may find no room.
    fn order(&mut self, port: u32, order: Order, tick: u64) {
        let _ = self.engine.command(EngineCommand::Order(Some(port), order));
        let record = Record::Order { tick, port: Some(port), order };
        if hand(&mut self.rings, &mut self.missing, record, 2).is_err() {
            self.missing += 1;
            self.shared.lost_records.fetch_add(1, Relaxed);
        }
    }

    /// One gesture frame that begins in time, for a caller that has its own clock.
    pub fn step(&mut self) {
        let begin = now_ns();
        self.frame();
        self.timed(FrameTiming { start: Start::default(), took: now_ns() - begin });
    }

    /// Sends the timing of a frame to the recorder; counts it as lost if the ring is full.
    fn timed(&mut self, timing: FrameTiming) {
        if self.rings.timings.push(timing).is_err() {
            self.shared.lost_timings.fetch_add(1, Relaxed);
        }
    }

    /// One gesture frame.
    pub fn frame(&mut self) {
        let begin = now_ns();
        let off = self.shared.disarm.swap(0, Acquire);
        for k in 0..self.engine.ports.len() {
            if off >> k.min(63) & 1 == 1 {
                self.order(k as u32, Order::Disarm, self.engine.due());
            }
        }
        self.commands();
        self.devices();
        let due = self.engine.due();
        self.engine.prepare();
        // a machine that stood still meanwhile: the force is of where the hand was then
        self.lapsed(now_ns() - begin, due);
        let Live { engine, rings, shared, missing, .. } = self;
        for (k, out) in engine.answer().enumerate() {
            let port = k as u32;
            // its life begins here, however long it waits on its way
            let sent = ForceFrame { t_host_ns: now_ns(), ..*out };
            if rings.forces.push((port, sent)).is_err() {
                shared.lost_forces.fetch_add(1, Relaxed);
            }
            note(rings, missing, shared, Record::Force { port, frame: *out });
        }
        let sound = engine.finish();
        if !put(&mut rings.sound, due, sound, &[]) {
            shared.lost_sound.fetch_add(sound.len() as u64, Relaxed);
        }
        #[cfg(feature = "system")]
        if let Some(audio) = rings.audio.as_mut().and_then(Outlet::now) {
            audio.put(sound);
        }
        shared.diverged.store(engine.has_diverged(), Relaxed);
        shared.dropped.store(engine.counts.dropped, Relaxed);
        shared.stale.store(engine.counts.stale, Relaxed);
        shared.clipped.store(engine.counts.clipped, Relaxed);
        self.regular();
    }

    fn commands(&mut self) {
        if let Some(record) = self.waiting.take() {
            self.keep(record);
        }
        // those that are there: who asks without end is no reason for the frame to wait
        for _ in 0..self.rings.commands.slots() {
            if self.waiting.is_some() {
                return;
            }
            let Ok((disarms, act)) = self.rings.commands.pop() else { return };
            if matches!(act, EngineCommand::Order(_, Order::Arm)) && disarms < self.shared.disarms.load(Relaxed) {
                continue;
            }
            let tick = self.engine.due();
            if let EngineCommand::Order(port, order) = act {
                self.keep(Record::Order { tick, port, order });
            }
            let number = if let EngineCommand::Swap(swap) = &act { Some(swap.number) } else { None };
            let marks = matches!(act, EngineCommand::Mark);
            let touched = if let EngineCommand::Touch(touch) = &act { Some(touch.touched()) } else { None };
            match (self.engine.command(act), touched) {
                (Some(Retired::Swap(gone)), _) => {
                    self.keep(Record::Swapped { tick, number: number.unwrap_or_default(), gone: Some(gone) });
                }
                (None, None) if number.is_some() => {
                    self.keep(Record::Swapped { tick, number: number.unwrap_or_default(), gone: None });
                }
                (Some(Retired::Gesture(gone)), Some(touched)) => {
                    self.keep(Record::Touched { tick, touched, gone: Some(gone) });
                }
                (_, Some(touched)) => self.keep(Record::Touched { tick, touched, gone: None }),
                (Some(retired), None) => self.keep(Record::Retired { tick, retired }),
                (None, None) if marks => self.keep(Record::Marked { tick, bits: self.engine.state.bits() }),
                (None, None) => {}
            }
        }
    }

    /// Hands over what must not be lost, or waits with it.
    fn keep(&mut self, record: Record) {
        if self.waiting.is_some() {
            // only the last order can come upon one that waits
            self.shared.lost_records.fetch_add(1, Relaxed);
            return;
        }
        self.waiting = hand(&mut self.rings, &mut self.missing, record, 2).err();
    }

    fn devices(&mut self) {
        // those that are there: one who sends without end is no reason for the forces of others to wait
        for _ in 0..self.rings.frames.slots() {
            let Ok((port, mut frame)) = self.rings.frames.pop() else { return };
            self.engine.take(port as usize, &mut frame);
            note(&mut self.rings, &mut self.missing, &self.shared, Record::Device { port, frame });
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
        let energy = due(self.every.energy).then_some(e.state.ledger.as_deref()).flatten();
        let energy = energy.map(|l| Record::Energy { tick, balance: l.balance() });
        let hash = due(self.every.hash).then(|| Record::Hash { tick, bits: e.state.bits() });
        for record in [energy, hash].into_iter().flatten() {
            note(&mut self.rings, &mut self.missing, &self.shared, record);
        }
        if due(self.waits) {
            for (k, p) in self.engine.ports.iter().enumerate() {
                let wait = p.chain.wait();
                if wait != Wait::Nothing {
                    let record = Record::Waiting { tick, port: k as u32, wait };
                    note(&mut self.rings, &mut self.missing, &self.shared, record);
                }
            }
        }
        if let Some(views) = self.rings.views.as_mut().filter(|_| due(self.every.view)) {
            let (x, d) = (&self.engine.state.x, &self.engine.state.d);
            if !put(views, tick, x, d) {
                self.shared.lost_views.fetch_add(1, Relaxed);
            }
        }
    }
}

/// Hands over one thing that happened, or counts it.
fn note(rings: &mut Rings, missing: &mut u64, shared: &Shared, record: Record) {
    if hand(rings, missing, record, KEPT).is_err() {
        *missing += 1;
        shared.lost_records.fetch_add(1, Relaxed);
    }
}

/// Hands over one thing that happened, and before it the count of what is missing there. Given back where fewer than
/// `room` places, at least two, are free.
// a record is as large as a place of the ring; a box would be a call of the allocator
#[allow(clippy::result_large_err)]
fn hand(rings: &mut Rings, missing: &mut u64, record: Record, room: usize) -> Result<(), Record> {
    if rings.records.slots() < room {
        return Err(record);
    }
    if *missing > 0 {
        let _ = rings.records.push(Record::Lost { tick: record.tick(), records: core::mem::take(missing) });
    }
    // there is room: only this thread fills the ring
    let _ = rings.records.push(record);
    Ok(())
}
