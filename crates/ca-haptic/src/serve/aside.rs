//! A sink on a thread of its own.
//!
//! Decides that no disk stands between a person and `ca disarm`, and none between the rings of the engine and another
//! file: the desk hands over and goes on, whatever a sink does. What waits for it is bounded by seconds of the
//! performance and by memory ([`Room`]); beyond that, frames, sound and pictures are left out of this file alone,
//! counted, and told where they are missing. What decides the future of an engine (changes, orders, reloads) is rare,
//! and always handed over. Once there is no room, half of it must be free before the next is taken: one long hole says
//! more than a thousand short ones. A hand-over that waits in the rings instead was tried: one slow file then made holes
//! in all of them, and the desk blind.
//!
//! The thread asks for a larger share of the cores rather than for real time: a writer that has much to catch up with
//! would keep a core from everything else, and bring the kernel's guard upon the engine.

use super::desk::{Happened, Sink, Wants};
use super::summary::Pulse;
use crate::error::FileError;
use crate::record::Record;
use crate::rt::{self, Granted, Wish};
use ca_core::Scene;
use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// How much may wait for a sink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// sound samples a second, by which ticks are seconds
    pub rate: f64,
    /// how late it may be written \[s\]
    pub seconds: f64,
    /// memory of what waits \[bytes\]
    pub bytes: usize,
}

impl Room {
    /// Half a minute of a performance, or a quarter of a gigabyte where that is less: what one device and its sound need.
    pub fn of(scene: &Scene) -> Room {
        Room { rate: scene.rate, seconds: 30.0, bytes: 1 << 28 }
    }
}

/// How late a sink may be written before people hear of it \[s\].
const LATE: f64 = 2.0;

/// One thing to be written.
enum Thing {
    Record(Box<Record>),
    Sound(u64, Vec<f64>),
    View(u64, Vec<f64>),
    Pulse(Pulse),
    Said(Happened),
    End,
}

impl Thing {
    /// When it happened, where that says how far a sink has come.
    fn tick(&self) -> Option<u64> {
        match self {
            Thing::Record(r) => Some(r.tick()),
            Thing::Sound(tick, _) | Thing::View(tick, _) => Some(*tick),
            Thing::Pulse(_) | Thing::Said(_) | Thing::End => None,
        }
    }

    fn bytes(&self) -> usize {
        size_of::<Thing>()
            + match self {
                Thing::Record(_) => size_of::<Record>(),
                Thing::Sound(_, v) | Thing::View(_, v) => size_of_val(&v[..]),
                Thing::Said(h) => h.text.len(),
                Thing::Pulse(_) | Thing::End => 0,
            }
    }
}

/// What both sides look at.
#[derive(Default)]
struct Shared {
    /// things, and their bytes
    waiting: AtomicUsize,
    bytes: AtomicUsize,
    /// the tick of what was written last
    done: AtomicU64,
    /// records, sound samples and pictures that found no room
    lost: [AtomicU64; 3],
    over: AtomicBool,
    failed: Mutex<Option<FileError>>,
}

impl Shared {
    fn failed(&self) -> Option<FileError> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    fn lost(&self) -> [u64; 3] {
        [0, 1, 2].map(|k| self.lost[k].load(Relaxed))
    }
}

/// Says that the thread has ended, however it did: nobody waits for it any more.
struct Over<'a>(&'a Shared);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.over.store(true, Relaxed);
    }
}

/// The desk's end.
pub struct Line {
    name: String,
    to: Sender<Thing>,
    shared: Arc<Shared>,
    wants: Wants,
    room: Room,
    /// the latest tick handed over
    newest: u64,
    /// there was no room, and not half of it is free again
    full: bool,
    /// records left out since the last that was handed over
    missing: u64,
    /// what was told: the loss, when \[ticks\], and how late it is to be for the next word \[s\]
    told: [u64; 3],
    told_at: u64,
    next: f64,
}

/// The owner's end.
pub struct Aside<T> {
    to: Sender<Thing>,
    shared: Arc<Shared>,
    granted: Granted,
    thread: Option<JoinHandle<Option<T>>>,
}

impl<T> Drop for Aside<T> {
    /// Waits for a thread that nobody ended, so that its sink is gone before the process is: what it half wrote is then
    /// removed.
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = self.to.send(Thing::End);
            let _ = thread.join();
        }
    }
}

impl<T: Sink + Send + 'static> Aside<T> {
    /// Moves a sink to a thread of this name, which asks the system for `wish`.
    pub fn start(name: &str, mut sink: T, room: Room, wish: Wish) -> Result<(Line, Aside<T>), FileError> {
        let (to, from) = channel();
        let (tell, granted) = channel();
        let shared = Arc::new(Shared::default());
        let (of, wants) = (shared.clone(), sink.wants());
        let thread = Builder::new()
            .name(name.into())
            .spawn(move || {
                let _over = Over(&of);
                let _ = tell.send(rt::ask(wish));
                match work(&mut sink, &from, &of) {
                    Ok(()) => Some(sink),
                    Err(e) => {
                        *of.failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
                        None
                    }
                }
            })
            .map_err(|e| FileError::content(format!("no thread to write with: {e}")))?;
        let line = Line {
            name: name.strip_prefix("ca ").unwrap_or(name).into(),
            to: to.clone(),
            shared: shared.clone(),
            wants,
            room,
            newest: 0,
            full: false,
            missing: 0,
            told: [0; 3],
            told_at: 0,
            next: LATE,
        };
        Ok((line, Aside { to, shared, granted: granted.recv().unwrap_or_default(), thread: Some(thread) }))
    }

    /// What the system granted its thread.
    pub fn granted(&self) -> &Granted {
        &self.granted
    }

    /// Records, sound samples and pictures that found no room on their way to this sink.
    pub fn lost(&self) -> [u64; 3] {
        self.shared.lost()
    }

    /// The sink, once everything handed over is written; none where it failed and the desk has told so.
    pub fn end(mut self) -> Result<Option<T>, FileError> {
        // where it failed nobody listens any more
        let _ = self.to.send(Thing::End);
        let sink = self.thread.take().and_then(|t| t.join().ok()).flatten();
        self.shared.failed().map_or(Ok(sink), Err)
    }
}

fn work(sink: &mut impl Sink, from: &Receiver<Thing>, shared: &Shared) -> Result<(), FileError> {
    while let Ok(thing) = from.recv() {
        let (tick, bytes) = (thing.tick(), thing.bytes());
        match thing {
            Thing::Record(r) => sink.record(&r)?,
            Thing::Sound(tick, frames) => sink.sound(tick, &frames)?,
            Thing::View(tick, x) => sink.view(tick, &x)?,
            Thing::Pulse(p) => sink.pulse(&p)?,
            Thing::Said(h) => sink.said(&h)?,
            Thing::End => break,
        }
        if let Some(tick) = tick {
            shared.done.fetch_max(tick, Relaxed);
        }
        shared.bytes.fetch_sub(bytes, Relaxed);
        shared.waiting.fetch_sub(1, Relaxed);
    }
    Ok(())
}

impl Line {
    fn put(&mut self, thing: Thing) -> Result<(), FileError> {
        self.newest = self.newest.max(thing.tick().unwrap_or(0));
        self.shared.waiting.fetch_add(1, Relaxed);
        self.shared.bytes.fetch_add(thing.bytes(), Relaxed);
        let gone = || FileError::content("the thread that wrote it has ended");
        self.to.send(thing).map_err(|_| self.shared.failed().unwrap_or_else(gone))
    }

    /// How late the sink is written \[s\].
    fn behind(&self) -> f64 {
        if self.shared.waiting.load(Relaxed) == 0 {
            return 0.0;
        }
        self.newest.saturating_sub(self.shared.done.load(Relaxed)) as f64 / self.room.rate
    }

    /// Whether something that happened at `tick` may wait, too. If not, `n` of this kind are lost.
    fn has_room(&mut self, tick: u64, kind: usize, n: u64) -> bool {
        // the next word of one that has ended is why
        if self.shared.over.load(Relaxed) {
            return true;
        }
        self.newest = self.newest.max(tick);
        let part = if self.full { 0.5 } else { 1.0 };
        let bytes = self.shared.bytes.load(Relaxed) as f64;
        self.full = self.behind() >= part * self.room.seconds || bytes >= part * self.room.bytes as f64;
        if self.full {
            self.shared.lost[kind].fetch_add(n, Relaxed);
        }
        !self.full
    }
}

impl Sink for Line {
    fn wants(&self) -> Wants {
        self.wants
    }

    fn lost(&self) -> [u64; 3] {
        self.shared.lost()
    }

    fn news(&mut self) -> Option<(bool, String)> {
        let lost = self.shared.lost();
        let first = self.told == [0; 3];
        if lost != self.told && (first || (self.newest - self.told_at) as f64 >= self.room.rate) {
            (self.told, self.told_at) = (lost, self.newest);
            let why = "it is written slower than it is played: write to a faster disk, or end what else keeps this machine busy";
            return Some((true, format!("{}: {} are missing so far; {why}", self.name, missing(lost))));
        }
        let behind = self.behind();
        // beyond that, what is lost says it
        if behind >= self.next && behind < self.room.seconds {
            self.next = 2.0 * behind;
            let most = self.room.seconds;
            return Some((
                true,
                format!("{}: written {behind:.1} s late; beyond {most} s something is lost", self.name),
            ));
        }
        if self.next > LATE && behind < 0.5 * LATE {
            self.next = LATE;
            return Some((false, format!("{}: written in time again", self.name)));
        }
        None
    }

    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        if !self.wants.records {
            return Ok(());
        }
        let tick = record.tick();
        let decides = matches!(record, Record::Spent { .. } | Record::Order { .. } | Record::Lost { .. });
        if !decides && !self.has_room(tick, 0, 1) {
            self.missing += 1;
            return Ok(());
        }
        if self.missing > 0 {
            let records = std::mem::take(&mut self.missing);
            self.put(Thing::Record(Box::new(Record::Lost { tick, records })))?;
        }
        self.put(Thing::Record(Box::new(record.clone())))
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        if self.wants.sound && self.has_room(tick, 1, frames.len() as u64) {
            self.put(Thing::Sound(tick, frames.to_vec()))?;
        }
        Ok(())
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        if self.wants.views && self.has_room(tick, 2, 1) {
            self.put(Thing::View(tick, x.to_vec()))?;
        }
        Ok(())
    }

    fn pulse(&mut self, pulse: &Pulse) -> Result<(), FileError> {
        if self.wants.pulses { self.put(Thing::Pulse(*pulse)) } else { Ok(()) }
    }

    fn said(&mut self, happened: &Happened) -> Result<(), FileError> {
        // one a second, or what a person did: a terminal that stands still is no reason to fill the memory
        let full = self.shared.bytes.load(Relaxed) >= 2 * self.room.bytes && !self.shared.over.load(Relaxed);
        if full { Ok(()) } else { self.put(Thing::Said(happened.clone())) }
    }
}

/// Records, sound samples and pictures that are missing, in words.
pub(super) fn missing(lost: [u64; 3]) -> String {
    let mut text = String::new();
    for (n, what) in lost.iter().zip(["records", "sound samples", "pictures"]).filter(|l| *l.0 > 0) {
        let _ = write!(text, "{}{n} {what}", if text.is_empty() { "" } else { ", " });
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::setup;
    use crate::engine::{Engine, Options, Port};
    use crate::guard::Order;
    use crate::serve::{Clock, Desk, Every, Live, rings};
    use ca_core::{Catalog, compile, model::read};

    const RATE: f64 = 48_000.0;
    /// Sound of a gesture frame of one channel.
    const FRAME: [f64; 16] = [0.0; 16];

    /// A disk that stands still until it is let go, and is full after so many blocks.
    struct Disk {
        still: Arc<Mutex<()>>,
        ticks: Vec<u64>,
        records: Vec<Record>,
        blocks: usize,
    }

    impl Sink for Disk {
        fn record(&mut self, record: &Record) -> Result<(), FileError> {
            let _still = self.still.lock().unwrap_or_else(PoisonError::into_inner);
            self.records.push(record.clone());
            Ok(())
        }
        fn sound(&mut self, tick: u64, _: &[f64]) -> Result<(), FileError> {
            let _still = self.still.lock().unwrap_or_else(PoisonError::into_inner);
            self.ticks.push(tick);
            if self.ticks.len() > self.blocks { Err(FileError::content("full")) } else { Ok(()) }
        }
    }

    fn disk(room: Room, blocks: usize) -> (Line, Aside<Disk>, Arc<Mutex<()>>) {
        let still = Arc::new(Mutex::new(()));
        let disk = Disk { still: still.clone(), ticks: vec![], records: vec![], blocks };
        let (line, aside) = Aside::start("ca disk", disk, room, Wish::default()).expect("a thread");
        (line, aside, still)
    }

    fn room(seconds: f64) -> Room {
        Room { rate: RATE, seconds, bytes: 1 << 28 }
    }

    #[test]
    fn what_waits_is_bounded_by_seconds_and_by_memory_and_the_rest_is_counted() {
        let each = size_of::<Thing>() + size_of_val(&FRAME);
        let by_bytes = Room { bytes: 700 * each, ..room(1e9) };
        // ten seconds of sound for a disk that stands still
        for (room, fits) in [(room(2.0), 6000), (room(0.5), 1500), (by_bytes, 700), (room(20.0), 30_000)] {
            let (mut line, aside, still) = disk(room, usize::MAX);
            let held = still.lock().expect("nobody panics");
            for n in 0..30_000 {
                line.sound(16 * n, &FRAME).expect("handed over, or left out");
            }
            assert_eq!(aside.lost(), [0, (30_000 - fits) * 16, 0], "{room:?}");
            drop(held);
            let disk = aside.end().expect("no failure").expect("a disk");
            assert!(disk.ticks.iter().copied().eq((0..fits).map(|n| 16 * n)), "{room:?}");
        }
        // a device at 3 kHz, its forces and two channels of sound, for as long as a disk may stand still
        let second = 6000 * (size_of::<Record>() + size_of::<Thing>()) + 3000 * (each + size_of_val(&FRAME));
        assert!(30 * second < 1 << 28, "{second} bytes a second");
    }

    #[test]
    fn a_loss_is_told_while_it_lasts_and_that_it_is_over() {
        let (mut line, aside, still) = disk(room(2.5), usize::MAX);
        let held = still.lock().expect("nobody panics");
        let mut told = Vec::new();
        for n in 0..15_000_u64 {
            line.sound(16 * n, &FRAME).expect("handed over, or left out");
            told.extend(line.news().map(|(bad, text)| (16.0 * n as f64 / RATE, bad, text)));
        }
        let at: Vec<f64> = told.iter().map(|t| t.0).collect();
        assert_eq!(at, [2.0, 2.5, 3.5, 4.5], "{told:?}");
        assert!(told.iter().all(|t| t.1));
        assert!(told[0].2.starts_with("disk: written 2.0 s late; beyond 2.5 s something is lost"), "{told:?}");
        for (k, samples) in [(1, 16), (2, 48_016), (3, 96_016)] {
            let text = format!("disk: {samples} sound samples are missing so far; ");
            assert!(told[k].2.starts_with(&text), "{told:?}");
        }
        drop(held);
        while line.shared.waiting.load(Relaxed) > 0 {
            std::thread::yield_now();
        }
        assert_eq!(line.news(), Some((false, "disk: written in time again".into())));
        assert_eq!(line.news(), None);
        // and there is room again, after one hole
        line.sound(240_000, &FRAME).expect("handed over");
        let lost = aside.lost();
        let ticks = aside.end().expect("no failure").expect("a disk").ticks;
        assert_eq!((ticks.len(), ticks[7499], ticks[7500]), (7501, 119_984, 240_000));
        assert_eq!(lost, [0, 240_000 - 120_000, 0]);
    }

    /// Ticks of sounds, number of records, words.
    type Heard = (Vec<u64>, u64, Vec<String>);

    /// What the desk says, and all it hands over.
    #[derive(Clone, Default)]
    struct Ear(Arc<Mutex<Heard>>);

    impl Ear {
        fn heard(&self) -> Heard {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
        }
    }

    impl Sink for Ear {
        fn record(&mut self, _: &Record) -> Result<(), FileError> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).1 += 1;
            Ok(())
        }
        fn sound(&mut self, tick: u64, _: &[f64]) -> Result<(), FileError> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).0.push(tick);
            Ok(())
        }
        fn said(&mut self, h: &Happened) -> Result<(), FileError> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).2.push(h.text.clone());
            Ok(())
        }
    }

    struct Played {
        ear: Ear,
        /// failures the desk knew of before the disk went on, and after
        broken: [usize; 2],
        disk: Result<Option<Disk>, FileError>,
        /// by the summary, and by the disk's own count
        lost: [[u64; 3]; 2],
    }

    /// So many gesture frames for a disk that may stand still all the while, and for somebody who hears everything. In
    /// the last one somebody arms.
    fn play(room: Room, blocks: usize, frames: u64, hold: bool) -> Played {
        let (model, _) = read::read(crate::engine::tests::KEY, "key.ca.toml", &Catalog::core());
        let scene = Arc::new(compile(&model, &Catalog::core(), &ca_core::Options::default()).expect("it compiles"));
        let engine = Engine::new(scene.clone(), vec![Port::new(&scene, setup())], Options::default());
        let (ends, mut gateway, desk_ends) = rings(&scene, 1, 0);
        let shared = Arc::new(crate::serve::Shared::default());
        let (line, aside, still) = disk(room, blocks);
        let held = hold.then(|| still.lock().unwrap_or_else(PoisonError::into_inner));
        let ear = Ear::default();
        let sinks: Vec<Box<dyn Sink>> = vec![Box::new(line), Box::new(ear.clone())];
        let mut desk = Desk::new(desk_ends, shared.clone(), scene, &engine.ports, sinks);
        let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, Every::default());
        for n in 0..frames {
            if n == frames - 1 {
                desk.order(None, Order::Arm).expect("asked");
            }
            live.frame();
            while gateway.forces.pop().is_ok() {}
            desk.turn();
        }
        let engine = live.run(Some(0));
        desk.turn();
        let before = desk.broken().len();
        // what was told while it stood still
        let ear = Ear(Arc::new(Mutex::new(ear.heard())));
        drop(held);
        if blocks < 100 && hold {
            // the desk learns of the failure if something is left to hand over
            while !aside.shared.over.load(Relaxed) {
                std::thread::yield_now();
            }
            desk.say(false, "is anybody there?".into());
        }
        desk.turn();
        let summary = desk.summary(&engine, vec![]);
        let lost = [[summary.lost_records, summary.lost_sound, summary.lost_views], aside.lost()];
        Played { ear, broken: [before, desk.broken().len()], disk: aside.end(), lost }
    }

    /// A sink that takes its time, and says when it is gone.
    struct Slow(Arc<AtomicBool>);

    impl Sink for Slow {
        fn sound(&mut self, _: u64, _: &[f64]) -> Result<(), FileError> {
            std::thread::sleep(std::time::Duration::from_millis(50));
            Ok(())
        }
    }

    impl Drop for Slow {
        fn drop(&mut self) {
            self.0.store(true, Relaxed);
        }
    }

    #[test]
    fn a_sink_that_nobody_ends_is_gone_with_its_owner() {
        let gone = Arc::new(AtomicBool::new(false));
        let (mut line, aside) = Aside::start("slow", Slow(gone.clone()), room(1.0), Wish::default()).expect("a thread");
        line.sound(0, &[0.0]).expect("handed over");
        drop(aside);
        assert!(gone.load(Relaxed), "what it half wrote would stay");
    }

    #[test]
    fn a_disk_that_stands_still_for_a_while_loses_nothing() {
        let p = play(room(2.0), usize::MAX, 5000, true);
        let ticks = p.disk.expect("no failure").expect("a disk").ticks;
        assert_eq!((p.broken, p.lost, ticks.len()), ([0, 0], [[0; 3]; 2], 5001));
        assert!(ticks.windows(2).all(|w| w[0] < w[1]));
        assert!(p.ear.heard().2.iter().all(|t| !t.contains("missing")), "{:?}", p.ear.heard().2);
    }

    #[test]
    fn a_disk_that_stands_still_for_long_loses_what_is_counted_and_no_other_file_does() {
        let p = play(room(1.0), usize::MAX, 9000, true);
        let (ticks, records, told) = p.ear.heard();
        // the others have everything, a force and a sound each, the orders and what is waited for besides: nobody waits for
        // the disk
        assert_eq!((ticks.len(), records), (9001, 9001 + 3));
        // a frame is as late as its force, which is of its end
        let fits = ticks.iter().filter(|t| **t + 16 <= 48_000).count();
        assert!(told.iter().any(|t| t.starts_with("disk: ") && t.contains("are missing so far")), "{told:?}");
        let disk = p.disk.expect("no failure").expect("a disk");
        assert_eq!(disk.ticks, ticks[..fits]);
        let forces = disk.records.iter().filter(|r| matches!(r, Record::Force { .. })).count();
        let missing = 9001 - fits as u64;
        // and that it waits, once
        assert_eq!((forces, p.lost), (fits, [[missing + 1, 16 * missing, 0]; 2]));
        // what decides the future is there, and before it the count of what is not
        let end = &disk.records[fits..];
        let [Record::Lost { records: a, .. }, Record::Order { order: Order::Arm, .. }, off @ ..] = end else {
            panic!("{end:?}")
        };
        let [Record::Lost { records: b, .. }, Record::Order { order: Order::Disarm, .. }] = off else {
            panic!("{off:?}")
        };
        // the very last force, which says that they are off, comes after the last order
        assert_eq!(a + b + 1, missing + 1);
    }

    #[test]
    fn a_disk_that_fails_with_much_behind_it_is_told_once_and_holds_up_nobody() {
        let p = play(room(2.0), 10, 5000, true);
        assert_eq!((p.broken, p.disk.is_ok_and(|d| d.is_none())), ([0, 1], true));
    }

    #[test]
    fn a_full_disk_is_told_once() {
        let p = play(room(2.0), 10, 3000, false);
        // by the desk if it came by again, else at the end
        assert_eq!(p.broken[1] + usize::from(p.disk.is_err()), 1);
        assert!(p.disk.is_err() || p.disk.is_ok_and(|d| d.is_none()));
    }
}
