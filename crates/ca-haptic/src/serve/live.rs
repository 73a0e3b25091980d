//! Runs the engine on its thread: reads rings, plays a gesture frame, writes rings, and waits.
//!
//! The loop calls the kernel only to wait. Data that does not fit in a ring is counted as lost. Memory to be freed goes
//! to the recorder, and is stored here while the ring is full.

#[cfg(feature = "system")]
use super::audio::Outlet;
use super::clock::{Clock, Start};
#[cfg(feature = "system")]
use super::clock::{Pace, wait_for};
use crate::block_ring::put;
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

/// The engine's side of the rings.
pub struct Rings {
    /// Device frames, with the number of the device.
    pub frames: Consumer<(u32, DeviceFrame)>,
    /// Force frames, with the number of the device.
    pub forces: Producer<(u32, ForceFrame)>,
    /// Commands, each with the number of disarm requests before it.
    pub commands: Consumer<(u64, EngineCommand)>,
    /// Records.
    pub records: Producer<Record>,
    /// Sound of each gesture frame: first tick, number of samples, interleaved samples.
    pub sound: Producer<f64>,
    /// Timing of each gesture frame.
    pub timings: Producer<FrameTiming>,
    /// Pictures: tick, number of values, displacements \[m\] and motion \[m\] per tick; `None` without a viewer.
    pub views: Option<Producer<f64>>,
    /// Output to a sound device, besides files.
    #[cfg(feature = "system")]
    pub audio: Option<Outlet>,
}

/// Timing of a gesture frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTiming {
    /// Delay of its start, and periods left out before it.
    pub start: Start,
    /// Computing time \[ns\].
    pub compute_ns: u64,
}

/// State that the engine thread shares with others while it runs.
#[derive(Debug, Default)]
pub struct Shared {
    /// Asks all threads to end.
    pub stop: AtomicBool,
    /// Devices to disarm with the next frame, one bit each. It bypasses the command ring, which may be full.
    pub disarm: AtomicU64,
    /// Number of disarm requests; an arm command from before the last one is void.
    pub disarms: AtomicU64,
    /// Periods left out.
    pub missed: AtomicU64,
    /// Timings lost because their ring was full.
    pub lost_timings: AtomicU64,
    /// Force frames lost because the gateway did not read them in time.
    pub lost_forces: AtomicU64,
    /// Records lost because their ring was full.
    pub lost_records: AtomicU64,
    /// Sound samples lost because their ring was full.
    pub lost_sound: AtomicU64,
    /// Pictures lost because their ring was full.
    pub lost_views: AtomicU64,
    /// Device frames dropped by the input checks.
    pub dropped: AtomicU64,
    /// Gesture frames without a new frame from a connected device.
    pub stale: AtomicU64,
    /// Sound samples at the peak limit.
    pub clipped: AtomicU64,
    /// True if the model has diverged.
    pub diverged: AtomicBool,
}

impl Shared {
    /// Returns the records, sound samples and pictures lost in full rings to the recorder.
    pub fn lost(&self) -> [u64; 3] {
        [&self.lost_records, &self.lost_sound, &self.lost_views].map(|n| n.load(Relaxed))
    }
}

/// An engine with its rings, to be moved to its thread.
pub struct Live {
    engine: Engine,
    rings: Rings,
    shared: Arc<Shared>,
    clock: Clock,
    every: RecordIntervals,
    /// Record that must not be freed here, waiting for space in the ring.
    waiting: Option<Record>,
    /// Records lost since the last one that was sent.
    missing: u64,
    waits: u64,
}

/// Interval between checks of what an armed device waits for \[s\].
const WAITS: f64 = 0.25;

/// Slots of the ring that frames leave free for records of commands, which are rare and affect everything after them.
const KEPT: usize = 64;

/// Intervals of regular records, in gesture frames; 0 for never.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordIntervals {
    /// Energy ledger, if the scene has one.
    pub energy: u64,
    /// Pictures.
    pub view: u64,
    /// Hashes of the state.
    pub hash: u64,
}

impl Live {
    /// Combines an engine with its rings.
    pub fn new(engine: Engine, rings: Rings, shared: Arc<Shared>, clock: Clock, every: RecordIntervals) -> Live {
        let waits = (WAITS * engine.scene.rate / f64::from(engine.scene.rates.ratio)).max(1.0) as u64;
        Live { engine, rings, shared, clock, every, waiting: None, missing: 0, waits }
    }

    /// Runs until [`Shared::stop`], or for `frames` gesture frames, and returns the engine. On the clock of a device,
    /// periods without a frame count too.
    #[cfg(feature = "system")]
    pub fn run(mut self, frames: Option<u64>) -> Engine {
        let scene = &self.engine.scene;
        let period = f64::from(scene.rates.ratio) * scene.rates.sample_dt;
        let (mut pace, mut waits) = (Pace::new(period), Waits::default());
        // on the clock of a device, frames are not due at a time: a stall shows as a long interval between two checks
        let (mut left, mut looked) = (frames, now_ns());
        while left != Some(0) {
            let mut blind = 0;
            if self.rings.audio.as_mut().is_some_and(Outlet::poll) {
                // another clock: deadlines start again
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
            self.timed(FrameTiming { start, compute_ns: now_ns() - begin });
            looked = now_ns();
            let alone = if matches!(self.clock, Clock::Device { .. }) { start.missed } else { 0 };
            left = left.map(|n| n.saturating_sub(alone.max(1)));
        }
        // the last frame turns forces off, so that devices need not wait for a timeout
        self.engine.command(EngineCommand::Order(None, Order::Disarm));
        self.store(Record::Order { tick: self.engine.due(), port: None, order: Order::Disarm });
        self.frame();
        if self.waiting.is_some() {
            self.shared.lost_records.fetch_add(1, Relaxed);
        }
        self.engine
    }

    /// Trips devices whose last force expired in a delay of `late` \[ns\], so that it does not return in one step.
    fn lapsed(&mut self, late: u64, tick: u64) {
        for k in 0..self.engine.ports.len() {
            let p = &self.engine.ports[k];
            let gives = matches!(p.hand.mode, Mode::Ramp | Mode::On | Mode::Damp);
            if gives && late >= u64::from(p.out.ttl_us) * 1000 {
                self.order(k as u32, Order::Trip(Cause::WatchdogOut), tick);
            }
        }
    }

    /// Executes an order at once. Only its record can be lost, if the ring is full.
    fn order(&mut self, port: u32, order: Order, tick: u64) {
        let _ = self.engine.command(EngineCommand::Order(Some(port), order));
        let record = Record::Order { tick, port: Some(port), order };
        if push_record(&mut self.rings, &mut self.missing, record, 2).is_err() {
            self.missing += 1;
            self.shared.lost_records.fetch_add(1, Relaxed);
        }
    }

    /// Plays one gesture frame that begins in time, for a caller with another clock.
    pub fn step(&mut self) {
        let begin = now_ns();
        self.frame();
        self.timed(FrameTiming { start: Start::default(), compute_ns: now_ns() - begin });
    }

    fn timed(&mut self, timing: FrameTiming) {
        if self.rings.timings.push(timing).is_err() {
            self.shared.lost_timings.fetch_add(1, Relaxed);
        }
    }

    /// Plays one gesture frame.
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
        // after a stall in between, the force belongs to an old position of the hand
        self.lapsed(now_ns() - begin, due);
        let Live { engine, rings, shared, missing, .. } = self;
        for (k, out) in engine.answer().enumerate() {
            let port = k as u32;
            // its lifetime starts here and includes the time in the ring
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
            self.store(record);
        }
        // only commands that wait now, so that endless commands do not delay the frame
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
                self.store(Record::Order { tick, port, order });
            }
            let number = if let EngineCommand::Swap(swap) = &act { Some(swap.number) } else { None };
            let marks = matches!(act, EngineCommand::Mark);
            let event = if let EngineCommand::Manual(input) = &act { Some(input.event()) } else { None };
            match (self.engine.command(act), event) {
                (Some(Retired::Swap(gone)), _) => {
                    self.store(Record::Swapped { tick, number: number.unwrap_or_default(), gone: Some(gone) });
                }
                (None, None) if number.is_some() => {
                    self.store(Record::Swapped { tick, number: number.unwrap_or_default(), gone: None });
                }
                (Some(Retired::Gesture(gone)), Some(event)) => {
                    self.store(Record::Manual { tick, event, gone: Some(gone) });
                }
                (_, Some(event)) => self.store(Record::Manual { tick, event, gone: None }),
                (Some(retired), None) => self.store(Record::Retired { tick, retired }),
                (None, None) if marks => self.store(Record::Marked { tick, bits: self.engine.state.bits() }),
                (None, None) => {}
            }
        }
    }

    /// Sends a record that must not be lost, or stores it in `waiting`.
    fn store(&mut self, record: Record) {
        if self.waiting.is_some() {
            // only the last order of `run` can find another record waiting
            self.shared.lost_records.fetch_add(1, Relaxed);
            return;
        }
        self.waiting = push_record(&mut self.rings, &mut self.missing, record, 2).err();
    }

    fn devices(&mut self) {
        // only frames that wait now, so that a device that never stops sending does not delay other forces
        for _ in 0..self.rings.frames.slots() {
            let Ok((port, mut frame)) = self.rings.frames.pop() else { return };
            self.engine.take(port as usize, &mut frame);
            note(&mut self.rings, &mut self.missing, &self.shared, Record::Device { port, frame });
            // each frame of the first device belongs to one frame of the engine
            if port == 0 && matches!(self.clock, Clock::Device { .. }) {
                return;
            }
        }
    }

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

fn note(rings: &mut Rings, missing: &mut u64, shared: &Shared, record: Record) {
    if push_record(rings, missing, record, KEPT).is_err() {
        *missing += 1;
        shared.lost_records.fetch_add(1, Relaxed);
    }
}

/// Sends a record, after the number of records missing before it. Returns it if fewer than `capacity` slots (at least two)
/// are free.
// a record is as large as a slot of the ring, and boxing it would allocate
#[allow(clippy::result_large_err)]
fn push_record(rings: &mut Rings, missing: &mut u64, record: Record, needed: usize) -> Result<(), Record> {
    if rings.records.slots() < needed {
        return Err(record);
    }
    if *missing > 0 {
        let _ = rings.records.push(Record::Lost { tick: record.tick(), records: core::mem::take(missing) });
    }
    // it fits, because only this thread writes to the ring
    let _ = rings.records.push(record);
    Ok(())
}
