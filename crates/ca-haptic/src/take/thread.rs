//! The writer on its own thread, behind rings the real-time thread never waits for.
//!
//! Decides that what finds no room is counted and gone, and that the count travels in its place among the records, so
//! that a reader knows where the hole is. Frames leave a few places free: what is asked of an engine is rare, decides
//! its future, and comes in boxes that must not be freed on the real-time thread. Each round takes note of the sound
//! there is *before* it drains the records, so that sound never comes before what made it. A round a hundredth of a
//! second, a chunk closed every fifth: a killed process loses at most that and a round.

use super::Header;
use super::flat::Rt;
use super::views::Level;
use super::write::{TakeWriter, Told};
use crate::blocks::{put, take};
use crate::error::{FileError, FileErrorKind};
use crate::record::Record;
use ca_core::Scene;
use rtrb::{Consumer, Producer, RingBuffer};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long rings hold what comes \[s\].
const HELD: f64 = 1.0;
/// Places that frames leave to what is asked of the engine.
const KEPT: usize = 64;
/// Time between rounds.
const ROUND: Duration = Duration::from_millis(10);
/// Time between chunks.
const CHUNK: Duration = Duration::from_millis(200);
/// Views that find room.
const VIEWS: usize = 16;

/// What was lost on the way, of everything so far.
#[derive(Default)]
struct Losses {
    records: AtomicU64,
    samples: AtomicU64,
    views: AtomicU64,
}

/// The end of the real-time thread. Nothing here allocates, frees, locks or waits.
pub struct Rings {
    records: Producer<Record>,
    sound: Producer<f64>,
    views: Producer<f64>,
    rt: Producer<Rt>,
    /// records lost since the last one that found room
    missing: u64,
    places: usize,
    losses: Arc<Losses>,
}

impl Rings {
    /// Hands over one thing that happened. Without room it is counted; its box, if it has one, is left behind for good,
    /// since it must not be freed here.
    pub fn record(&mut self, record: Record) {
        let many = matches!(record, Record::Device { .. } | Record::Force { .. });
        if self.records.slots() < if many { KEPT } else { 2 } {
            self.missing += 1;
            self.losses.records.fetch_add(1, Ordering::Relaxed);
            core::mem::forget(record);
            return;
        }
        let tick = record.tick();
        if self.missing > 0 && self.records.push(Record::Lost { tick, records: self.missing }).is_ok() {
            self.missing = 0;
        }
        // there is room: only this thread fills the ring
        if let Err(rtrb::PushError::Full(record)) = self.records.push(record) {
            core::mem::forget(record);
        }
    }

    /// Hands over the sound of a gesture frame, interleaved, whose first sample is that of `tick`.
    pub fn sound(&mut self, tick: u64, samples: &[f64]) {
        if !put(&mut self.sound, [tick as f64, samples.len() as f64], samples) {
            self.losses.samples.fetch_add(samples.len() as u64, Ordering::Relaxed);
        }
    }

    /// Hands over the displacements of the state, to be drawn.
    pub fn view(&mut self, tick: u64, x: &[f64]) {
        if x.len() != self.places || !put(&mut self.views, [tick as f64, x.len() as f64], x) {
            self.losses.views.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Hands over how this thread does. Without room it is left out: there will be another.
    pub fn stats(&mut self, rt: Rt) {
        let _ = self.rt.push(rt);
    }

    /// Records and sound samples that found no room so far.
    pub fn lost(&self) -> u64 {
        self.losses.records.load(Ordering::Relaxed) + self.losses.samples.load(Ordering::Relaxed)
    }
}

/// A take being written by its thread.
pub struct Recorder {
    thread: Option<JoinHandle<Result<Told, FileError>>>,
    stop: Arc<AtomicBool>,
    words: mpsc::Sender<Words>,
    losses: Arc<Losses>,
}

impl Recorder {
    /// Begins the take at `path`, and gives the rings to feed it by.
    pub fn start(path: impl AsRef<Path>, header: &Header, scene: &Scene) -> Result<(Recorder, Rings), FileError> {
        let (desk, rings, words) = desk(TakeWriter::create(&path, header, scene)?, header, scene);
        let stop = Arc::<AtomicBool>::default();
        let losses = desk.losses.clone();
        let until = stop.clone();
        let thread = std::thread::Builder::new()
            .name("take".into())
            .spawn(move || desk.run(&until))
            .map_err(|e| FileError::io(path.as_ref(), "no thread to write it", &e))?;
        Ok((Recorder { thread: Some(thread), stop, words, losses }, rings))
    }

    /// Writes words about `name`, at about now.
    pub fn log(&self, level: Level, name: &str, message: &str) {
        // a writer that gave up says so at the end
        let _ = self.words.send((level, name.into(), message.into()));
    }

    /// Records and sound samples that found no room so far.
    pub fn lost(&self) -> u64 {
        self.losses.records.load(Ordering::Relaxed) + self.losses.samples.load(Ordering::Relaxed)
    }

    /// Whether it still writes: a full disk ends that.
    pub fn is_writing(&self) -> bool {
        self.thread.as_ref().is_some_and(|t| !t.is_finished())
    }

    /// Writes what is still in the rings and completes the file. The real-time thread must be done with its rings.
    pub fn finish(mut self) -> Result<Told, FileError> {
        self.end().unwrap_or_else(|| Ok(Told::default()))
    }

    fn end(&mut self) -> Option<Result<Told, FileError>> {
        self.stop.store(true, Ordering::Release);
        let gone = || Err(FileError::new(FileErrorKind::Io, "the thread that writes the take is gone"));
        self.thread.take().map(|t| t.join().unwrap_or_else(|_| gone()))
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

/// Both ends of the rings of a take, and a way to send words.
fn desk(writer: TakeWriter, header: &Header, scene: &Scene) -> (Desk, Rings, mpsc::Sender<Words>) {
    let ticks = (HELD * scene.rate) as usize;
    let frames = ticks / scene.ratio.max(1) as usize + 1;
    let (records, from_records) = RingBuffer::new(frames * (2 * header.setups.len() + 1) + 2 * KEPT);
    let (sound, from_sound) = RingBuffer::new(ticks * scene.channels + 2 * frames + 2);
    let (views, from_views) = RingBuffer::new(VIEWS * (writer.places() + 2));
    let (rt, from_rt) = RingBuffer::new(VIEWS);
    let losses = Arc::<Losses>::default();
    let (words, from_words) = mpsc::channel();
    let rings = Rings { records, sound, views, rt, missing: 0, places: writer.places(), losses: losses.clone() };
    let desk = Desk {
        writer,
        records: from_records,
        sound: from_sound,
        views: from_views,
        rt: from_rt,
        words: from_words,
        losses,
        told: [0; 3],
    };
    (desk, rings, words)
}

/// How grave, about what, and what.
type Words = (Level, String, String);

/// The other end of the rings.
struct Desk {
    writer: TakeWriter,
    records: Consumer<Record>,
    sound: Consumer<f64>,
    views: Consumer<f64>,
    rt: Consumer<Rt>,
    words: mpsc::Receiver<Words>,
    losses: Arc<Losses>,
    /// losses that are written: records, samples, views
    told: [u64; 3],
}

impl Desk {
    fn run(mut self, stop: &AtomicBool) -> Result<Told, FileError> {
        let mut flushed = Instant::now();
        let mut buffer = Vec::new();
        loop {
            // before the round, so that the last round takes all there is
            let last = stop.load(Ordering::Acquire);
            self.round(&mut buffer)?;
            if last {
                break;
            }
            if flushed.elapsed() >= CHUNK {
                self.writer.flush()?;
                flushed = Instant::now();
            }
            std::thread::sleep(ROUND);
        }
        self.end()
    }

    /// What was lost since the last record stands at the end.
    fn end(mut self) -> Result<Told, FileError> {
        self.losses(true)?;
        self.writer.finish()
    }

    fn round(&mut self, buffer: &mut Vec<f64>) -> Result<(), FileError> {
        let mut heard = self.sound.slots();
        for _ in 0..self.records.slots() {
            match self.records.pop() {
                Ok(record) => {
                    if let Record::Lost { records, .. } = record {
                        self.told[0] += records;
                    }
                    self.writer.record(record)?;
                }
                Err(_) => break,
            }
        }
        while heard > 0 {
            let Some(tick) = take(&mut self.sound, buffer) else { break };
            heard = heard.saturating_sub(buffer.len() + 2);
            self.writer.sound(tick, buffer)?;
        }
        while let Some(tick) = take(&mut self.views, buffer) {
            self.writer.view(tick, buffer)?;
        }
        while let Ok(rt) = self.rt.pop() {
            self.writer.stats(&rt)?;
        }
        while let Ok((level, name, message)) = self.words.try_recv() {
            self.writer.log(self.writer.tick(), level, &name, &message)?;
        }
        self.losses(false)
    }

    /// Losses of sound and views; those of records come in their place, and at the end.
    fn losses(&mut self, end: bool) -> Result<(), FileError> {
        let read = |a: &AtomicU64| a.load(Ordering::Relaxed);
        let now = [read(&self.losses.records), read(&self.losses.samples), read(&self.losses.views)];
        let records = if end { now[0] - self.told[0] } else { 0 };
        let [samples, views] = [now[1] - self.told[1], now[2] - self.told[2]];
        if records + samples + views > 0 {
            self.told = [self.told[0] + records, now[1], now[2]];
            self.writer.lost(records, samples, views)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::Calibration;
    use crate::engine::{Act, Engine, Setup};
    use crate::frame::DeviceFrame;
    use crate::profile::Profile;
    use crate::take::{Event, Replay, Take};
    use ca_core::model::read;
    use ca_core::{Catalog, Options, compile};

    const KEY: &str = "[TGR]\nkey = { device = \"key\", dof = 0 }\n[SOL]\nwall = {}\n\
        [RES]\nspring = { between = [\"key\", \"wall\"], k = 500 }\n[SOX]\nout = { from = \"key\" }\n";

    fn begin(path: &Path) -> (Desk, Rings, Engine) {
        let (model, _) = read::read(KEY, "key.ca.toml", &Catalog::core());
        let scene = compile(&model, &Catalog::core(), &Options::default()).expect("it compiles");
        let profile = Profile { dof: 1, ..Profile::shipped("tgr12").expect("shipped") };
        let setup = Setup { device: "key".into(), profile, calibration: Calibration::default(), gains: vec![] };
        let own = crate::engine::Options::default();
        let header = Header::new(&model, vec![], Options::default(), &scene, vec![setup], own);
        let writer = TakeWriter::create(path, &header, &scene).expect("a file");
        let (desk, rings, _) = desk(writer, &header, &scene);
        (desk, rings, header.engine(&Catalog::core()).expect("an engine"))
    }

    fn play(e: &mut Engine, rings: &mut Rings, frames: u64) {
        for _ in 0..frames {
            let due = e.due();
            let mut frame = DeviceFrame::new("key", 1);
            (frame.session, frame.seq, frame.pos[0]) = (1, due + 1, 1e-3 * (due as f64 * 1e-3).sin());
            e.take(0, &mut frame);
            rings.record(Record::Device { port: 0, frame });
            let frame = *e.answer().next().expect("one device");
            rings.record(Record::Force { port: 0, frame });
            let x = e.state.x.clone();
            rings.sound(due, e.finish());
            rings.view(due, &x);
        }
    }

    #[test]
    fn what_finds_no_room_is_counted_and_told_where_it_is_missing() {
        let dir = tempfile::tempdir().expect("a directory");
        let path = dir.path().join("a.mcap");
        let (mut desk, mut rings, mut e) = begin(&path);
        // a ring holds a second: nobody reads for two
        play(&mut e, &mut rings, 6000);
        // what is asked of the engine still finds room
        let spent = e.act(Act::Set(Box::default())).expect("spent");
        rings.record(Record::Spent { tick: e.due(), spent });
        let mut buffer = Vec::new();
        desk.round(&mut buffer).expect("written");
        let early = rings.lost();
        assert!(early > 2000, "{early}");
        play(&mut e, &mut rings, 100);
        assert_eq!(rings.lost(), early, "there is room again");
        desk.round(&mut buffer).expect("written");
        let told = desk.end().expect("finished");
        assert_eq!(told.lost, early);

        let take = Take::open(&path).expect("a take");
        let s = take.summary().expect("a summary");
        assert_eq!(s.lost[0] + s.lost[1], early);
        assert!(s.lost[1] >= 40_000 && s.lost[2] > 5000, "{:?}", s.lost);
        // the hole stands right before the change, which is there
        let events: Vec<Event> = take.events().expect("open").map(|e| e.expect("read")).collect();
        let hole = events.iter().position(|e| matches!(e, Event::Lost(l) if l.records > 0)).expect("a hole");
        let change = events.iter().position(|e| matches!(e, Event::Change(..))).expect("the change");
        let is_frame = |e: &Event| matches!(e, Event::Device(..) | Event::Force(..));
        assert!(hole < change && !events[hole..change].iter().any(is_frame));
        // and a replay stands by what is before it
        let r = Replay::new(&take, &Catalog::core()).expect("an engine");
        let v = r.run(&take, &mut |_| (), &mut |_| Ok(())).expect("replayed");
        assert!(v.difference.is_none() && !v.is_identical(), "{v:?}");
        let before = events[..hole].iter().filter(|e| matches!(e, Event::Force(..))).count() as u64;
        assert!(v.forces == before && before > 4000, "{v:?}");
        assert!(v.hole.is_some_and(|t| t > 1.3 && t < 2.0), "{v:?}");
    }
}
