//! A sink on a thread of its own.
//!
//! Decides that no disk stands between a person and `ca disarm`: the desk hands over and goes on. It hands over without
//! a bound of its own, but while too much waits it leaves what follows in the rings of the engine, which hold two
//! seconds; so memory is bounded, and what finds no room is counted in one place.

use super::desk::{Happened, Sink};
use super::summary::Pulse;
use crate::error::FileError;
use crate::record::Record;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};

/// Things that may wait: seconds of a performance, some tens of megabytes.
const FULL: usize = 20_000;

/// One thing to be written.
enum Thing {
    Record(Box<Record>),
    Sound(u64, Vec<f64>),
    View(u64, Vec<f64>),
    Pulse(Pulse),
    Said(Happened),
    End,
}

/// What both sides look at.
#[derive(Default)]
struct Shared {
    waiting: AtomicUsize,
    over: AtomicBool,
    failed: Mutex<Option<FileError>>,
}

impl Shared {
    fn failed(&self) -> Option<FileError> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner).take()
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
    to: Sender<Thing>,
    shared: Arc<Shared>,
}

/// The owner's end.
pub struct Aside<T> {
    to: Sender<Thing>,
    shared: Arc<Shared>,
    thread: JoinHandle<Option<T>>,
}

impl<T: Sink + Send + 'static> Aside<T> {
    /// Moves a sink to a thread of this name.
    pub fn start(name: &str, mut sink: T) -> Result<(Line, Aside<T>), FileError> {
        let (to, from) = channel();
        let shared = Arc::new(Shared::default());
        let of = shared.clone();
        let thread = Builder::new()
            .name(name.into())
            .spawn(move || {
                let _over = Over(&of);
                match work(&mut sink, &from, &of.waiting) {
                    Ok(()) => Some(sink),
                    Err(e) => {
                        *of.failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
                        None
                    }
                }
            })
            .map_err(|e| FileError::content(format!("no thread to write with: {e}")))?;
        Ok((Line { to: to.clone(), shared: shared.clone() }, Aside { to, shared, thread }))
    }

    /// The sink, once everything handed over is written; none where it failed and the desk has told so.
    pub fn end(self) -> Result<Option<T>, FileError> {
        // where it failed nobody listens any more
        let _ = self.to.send(Thing::End);
        let sink = self.thread.join().unwrap_or_default();
        self.shared.failed().map_or(Ok(sink), Err)
    }
}

fn work(sink: &mut impl Sink, from: &Receiver<Thing>, waiting: &AtomicUsize) -> Result<(), FileError> {
    while let Ok(thing) = from.recv() {
        waiting.fetch_sub(1, Relaxed);
        match thing {
            Thing::Record(r) => sink.record(&r)?,
            Thing::Sound(tick, frames) => sink.sound(tick, &frames)?,
            Thing::View(tick, x) => sink.view(tick, &x)?,
            Thing::Pulse(p) => sink.pulse(&p)?,
            Thing::Said(h) => sink.said(&h)?,
            Thing::End => break,
        }
    }
    Ok(())
}

impl Line {
    fn put(&self, thing: Thing) -> Result<(), FileError> {
        self.shared.waiting.fetch_add(1, Relaxed);
        let gone = || FileError::content("the thread that wrote it has ended");
        self.to.send(thing).map_err(|_| self.shared.failed().unwrap_or_else(gone))
    }
}

impl Sink for Line {
    fn is_ready(&self) -> bool {
        // the next word of one that has ended is why
        self.shared.over.load(Relaxed) || self.shared.waiting.load(Relaxed) < FULL
    }

    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        self.put(Thing::Record(Box::new(record.clone())))
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        self.put(Thing::Sound(tick, frames.to_vec()))
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        self.put(Thing::View(tick, x.to_vec()))
    }

    fn pulse(&mut self, pulse: &Pulse) -> Result<(), FileError> {
        self.put(Thing::Pulse(*pulse))
    }

    fn said(&mut self, happened: &Happened) -> Result<(), FileError> {
        self.put(Thing::Said(happened.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::setup;
    use crate::engine::{Engine, Options, Port};
    use crate::guard::Order;
    use crate::serve::{Clock, Desk, Every, Live, rings};
    use ca_core::{Catalog, compile, model::read};

    /// A disk that stands still until it is let go, and one that is full.
    struct Disk {
        still: Arc<Mutex<()>>,
        ticks: Vec<u64>,
        room: usize,
    }

    impl Sink for Disk {
        fn sound(&mut self, tick: u64, _: &[f64]) -> Result<(), FileError> {
            let _still = self.still.lock().unwrap_or_else(PoisonError::into_inner);
            self.ticks.push(tick);
            if self.ticks.len() > self.room { Err(FileError::content("full")) } else { Ok(()) }
        }
    }

    fn play(room: usize, frames: u64, hold: bool) -> ([usize; 2], Result<Option<Disk>, FileError>, u64) {
        let (model, _) = read::read(crate::engine::tests::KEY, "key.ca.toml", &Catalog::core());
        let scene = Arc::new(compile(&model, &Catalog::core(), &ca_core::Options::default()).expect("it compiles"));
        let engine = Engine::new(scene.clone(), vec![Port::new(&scene, setup())], Options::default());
        let (ends, mut gateway, desk_ends) = rings(&scene, 1, 0);
        let shared = Arc::new(crate::serve::Shared::default());
        let still = Arc::new(Mutex::new(()));
        let held = hold.then(|| still.lock().unwrap_or_else(PoisonError::into_inner));
        let (line, disk) = Aside::start("disk", Disk { still: still.clone(), ticks: vec![], room }).expect("a thread");
        let mut desk = Desk::new(desk_ends, shared.clone(), scene, &engine.ports, vec![Box::new(line)]);
        let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, Every::default());
        for n in 0..frames {
            if hold && n == frames - 1 {
                // whatever waits, what people ask goes to the engine
                desk.order(None, Order::Arm).expect("asked");
            }
            live.frame();
            while gateway.forces.pop().is_ok() {}
            desk.turn();
        }
        let engine = live.run(Some(0));
        drop(held);
        let before = desk.broken().len();
        if room < 100 && hold {
            // the desk comes by again, and goes on; it learns of the failure if something was left to hand over
            for _ in 0..100_000 {
                if !desk.broken().is_empty() {
                    break;
                }
                desk.turn();
                std::thread::yield_now();
            }
        }
        let told = desk.broken().len();
        desk.end();
        let summary = desk.summary(&engine, vec![]);
        ([before, told], disk.end(), summary.lost_sound)
    }

    #[test]
    fn a_disk_that_stands_still_holds_up_nobody_and_loses_nothing() {
        // a force and a sound each: more than may wait, and in the rings what came after
        let frames = FULL as u64 / 2 + 3000;
        let ([_, broken], disk, lost) = play(usize::MAX, frames, true);
        let ticks = disk.expect("no failure").expect("a disk").ticks;
        assert_eq!((broken, lost, ticks.len() as u64), (0, 0, frames + 1));
        assert!(ticks.windows(2).all(|w| w[0] < w[1]));
    }

    #[test]
    fn a_disk_that_fails_with_much_behind_it_is_told_once_and_holds_up_nobody() {
        let ([before, told], disk, lost) = play(10, FULL as u64 / 2 + 3000, true);
        assert_eq!((before, told + usize::from(disk.is_err()), lost), (0, 1, 0));
    }

    #[test]
    fn a_full_disk_is_told_once() {
        let ([_, broken], disk, _) = play(10, 3000, false);
        // by the desk if it came by again, else at the end
        assert_eq!(broken + usize::from(disk.is_err()), 1);
        assert!(disk.is_err() || disk.is_ok_and(|d| d.is_none()));
    }
}
