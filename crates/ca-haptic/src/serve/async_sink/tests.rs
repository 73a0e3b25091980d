//! Tests an asynchronous sink under load, on a slow disk and at its end.

use super::*;
use crate::engine::tests::setup;
use crate::engine::{Engine, Options, Port};
use crate::guard::Order;
use crate::serve::{Clock, Live, RecordIntervals, Recorder, rings};
use ca_compile::compile;
use ca_model::read;

const RATE: f64 = 48_000.0;
/// Sound of a gesture frame of one channel.
const FRAME: [f64; 16] = [0.0; 16];

/// A disk that blocks while `still` is locked, and is full after `blocks` blocks.
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

fn disk(limits: BufferLimits, blocks: usize) -> (SinkHandle, AsyncSink<Disk>, Arc<Mutex<()>>) {
    let still = Arc::new(Mutex::new(()));
    let disk = Disk { still: still.clone(), ticks: vec![], records: vec![], blocks };
    let (line, aside) = AsyncSink::start("ca disk", disk, limits, RtRequest::default()).expect("a thread");
    (line, aside, still)
}

fn limits(seconds: f64) -> BufferLimits {
    BufferLimits { rate: RATE, seconds, bytes: 1 << 28 }
}

#[test]
fn what_waits_is_bounded_by_seconds_and_by_memory_and_the_rest_is_counted() {
    let each = size_of::<Message>() + size_of_val(&FRAME);
    let by_bytes = BufferLimits { bytes: 700 * each, ..limits(1e9) };
    // 10 s of sound for a blocked disk
    for (limits, fits) in [(limits(2.0), 6000), (limits(0.5), 1500), (by_bytes, 700), (limits(20.0), 30_000)] {
        let (mut line, aside, still) = disk(limits, usize::MAX);
        let held = still.lock().expect("nobody panics");
        for n in 0..30_000 {
            line.sound(16 * n, &FRAME).expect("handed over, or left out");
        }
        assert_eq!(aside.lost(), [0, (30_000 - fits) * 16, 0], "{limits:?}");
        drop(held);
        let disk = aside.end().expect("no failure").expect("a disk");
        assert!(disk.ticks.iter().copied().eq((0..fits).map(|n| 16 * n)), "{limits:?}");
    }
    // 30 s of a device at 3 kHz, its forces and two channels of sound fit in 256 MB
    let second = 6000 * (size_of::<Record>() + size_of::<Message>()) + 3000 * (each + size_of_val(&FRAME));
    assert!(30 * second < 1 << 28, "{second} bytes a second");
}

#[test]
fn a_loss_is_reported_while_it_lasts_and_that_it_is_over() {
    let (mut line, aside, still) = disk(limits(2.5), usize::MAX);
    let held = still.lock().expect("nobody panics");
    let mut reported = Vec::new();
    for n in 0..15_000_u64 {
        line.sound(16 * n, &FRAME).expect("handed over, or left out");
        reported.extend(line.poll_notice().map(|(bad, text)| (16.0 * n as f64 / RATE, bad, text)));
    }
    let at: Vec<f64> = reported.iter().map(|t| t.0).collect();
    assert_eq!(at, [2.0, 2.5, 3.5, 4.5], "{reported:?}");
    assert!(reported.iter().all(|t| t.1));
    assert!(reported[0].2.starts_with("disk: written 2.0 s late; data are lost beyond 2.5 s"), "{reported:?}");
    for (k, samples) in [(1, 16), (2, 48_016), (3, 96_016)] {
        let text = format!("disk: {samples} sound samples lost so far, because ");
        assert!(reported[k].2.starts_with(&text), "{reported:?}");
    }
    drop(held);
    while line.shared.waiting.load(Relaxed) > 0 {
        std::thread::yield_now();
    }
    assert_eq!(line.poll_notice(), Some((false, "disk: written in time again".into())));
    assert_eq!(line.poll_notice(), None);
    // data is accepted again, after one gap
    line.sound(240_000, &FRAME).expect("handed over");
    let lost = aside.lost();
    let ticks = aside.end().expect("no failure").expect("a disk").ticks;
    assert_eq!((ticks.len(), ticks[7499], ticks[7500]), (7501, 119_984, 240_000));
    assert_eq!(lost, [0, 240_000 - 120_000, 0]);
}

/// Ticks of sounds, number of records, messages.
type Received = (Vec<u64>, u64, Vec<String>);

/// A sink that stores everything from the recorder.
#[derive(Clone, Default)]
struct RecordingSink(Arc<Mutex<Received>>);

impl RecordingSink {
    fn received(&self) -> Received {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Sink for RecordingSink {
    fn record(&mut self, _: &Record) -> Result<(), FileError> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).1 += 1;
        Ok(())
    }
    fn sound(&mut self, tick: u64, _: &[f64]) -> Result<(), FileError> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).0.push(tick);
        Ok(())
    }
    fn notice(&mut self, h: &Notice) -> Result<(), FileError> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).2.push(h.text.clone());
        Ok(())
    }
}

struct Played {
    sink: RecordingSink,
    /// Failures known to the recorder before the disk continued, and after.
    broken: [usize; 2],
    disk: Result<Option<Disk>, FileError>,
    /// Losses by the summary, and by the sink of the disk.
    lost: [[u64; 3]; 2],
}

/// Plays for a disk, which blocks all the while if `hold`, and for a sink that stores all. Arms in the last frame.
fn play(limits: BufferLimits, blocks: usize, frames: u64, hold: bool) -> Played {
    let (model, _) = read::read(crate::engine::tests::KEY, "key.ca.toml", &ca_model::catalog());
    let scene =
        Arc::new(compile(&model, &ca_model::catalog(), &ca_compile::Options::default()).expect("it compiles").scene);
    let engine = Engine::new(scene.clone(), vec![Port::new(&scene, setup())], Options::default());
    let (ends, mut gateway, recorder_ends) = rings(&scene, 1, 0);
    let shared = Arc::new(crate::serve::Shared::default());
    let (line, aside, still) = disk(limits, blocks);
    let held = hold.then(|| still.lock().unwrap_or_else(PoisonError::into_inner));
    let sink = RecordingSink::default();
    let sinks: Vec<Box<dyn Sink>> = vec![Box::new(line), Box::new(sink.clone())];
    let mut recorder = Recorder::new(recorder_ends, shared.clone(), scene, &engine.ports, sinks);
    let mut live = Live::new(engine, ends, shared, Clock::Device { patience: 0 }, RecordIntervals::default());
    for n in 0..frames {
        if n == frames - 1 {
            recorder.order(None, Order::Arm).expect("asked");
        }
        live.frame();
        while gateway.forces.pop().is_ok() {}
        recorder.poll();
    }
    let engine = live.run(Some(0));
    recorder.poll();
    let before = recorder.broken().len();
    // reports while the disk was blocked
    let sink = RecordingSink(Arc::new(Mutex::new(sink.received())));
    drop(held);
    if blocks < 100 && hold {
        // the recorder detects the failure when it hands over the next message
        while !aside.shared.ended.load(Relaxed) {
            std::thread::yield_now();
        }
        recorder.say(false, "is anybody there?".into());
    }
    recorder.poll();
    let summary = recorder.summary(&engine, vec![]);
    let lost = [[summary.lost_records, summary.lost_sound, summary.lost_views], aside.lost()];
    Played { sink, broken: [before, recorder.broken().len()], disk: aside.end(), lost }
}

/// A slow sink that sets a flag when it is dropped.
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
    let (mut line, aside) =
        AsyncSink::start("slow", Slow(gone.clone()), limits(1.0), RtRequest::default()).expect("a thread");
    line.sound(0, &[0.0]).expect("handed over");
    drop(aside);
    assert!(gone.load(Relaxed), "what it half wrote would stay");
}

#[test]
fn a_disk_that_stands_still_for_a_while_loses_nothing() {
    let p = play(limits(2.0), usize::MAX, 5000, true);
    let ticks = p.disk.expect("no failure").expect("a disk").ticks;
    assert_eq!((p.broken, p.lost, ticks.len()), ([0, 0], [[0; 3]; 2], 5001));
    assert!(ticks.windows(2).all(|w| w[0] < w[1]));
    assert!(p.sink.received().2.iter().all(|t| !t.contains("lost so far")), "{:?}", p.sink.received().2);
}

#[test]
fn a_disk_that_stands_still_for_long_loses_what_is_counted_and_no_other_file_does() {
    let p = play(limits(1.0), usize::MAX, 9000, true);
    let (ticks, records, reported) = p.sink.received();
    // the other sink does not wait for the disk: it has a force and a sound per frame, two orders and a wait
    assert_eq!((ticks.len(), records), (9001, 9001 + 3));
    // a frame has the tick of its force, which is at its end
    let fits = ticks.iter().filter(|t| **t + 16 <= 48_000).count();
    assert!(reported.iter().any(|t| t.starts_with("disk: ") && t.contains("lost so far")), "{reported:?}");
    let disk = p.disk.expect("no failure").expect("a disk");
    assert_eq!(disk.ticks, ticks[..fits]);
    let forces = disk.records.iter().filter(|r| matches!(r, Record::Force { .. })).count();
    let missing = 9001 - fits as u64;
    // and one `Waiting` record
    assert_eq!((forces, p.lost), (fits, [[missing + 1, 16 * missing, 0]; 2]));
    // orders are present, each after the number of missing records
    let end = &disk.records[fits..];
    let [Record::Lost { records: a, .. }, Record::Order { order: Order::Arm, .. }, off @ ..] = end else {
        panic!("{end:?}")
    };
    let [Record::Lost { records: b, .. }, Record::Order { order: Order::Disarm, .. }] = off else { panic!("{off:?}") };
    // the last force, with forces off, comes after the last order
    assert_eq!(a + b + 1, missing + 1);
}

#[test]
fn a_disk_that_fails_with_much_behind_it_is_reported_once_and_holds_up_nobody() {
    let p = play(limits(2.0), 10, 5000, true);
    assert_eq!((p.broken, p.disk.is_ok_and(|d| d.is_none())), ([0, 1], true));
}

#[test]
fn a_full_disk_is_reported_once() {
    let p = play(limits(2.0), 10, 3000, false);
    // by the recorder if it polled again, else at the end
    assert_eq!(p.broken[1] + usize::from(p.disk.is_err()), 1);
    assert!(p.disk.is_err() || p.disk.is_ok_and(|d| d.is_none()));
}

/// After a long pause, a sink is not late with the next data, and loses none of it.
#[test]
fn who_had_nothing_to_write_is_not_late() {
    let (mut line, aside, still) = disk(limits(2.0), usize::MAX);
    let held = still.lock().expect("nobody panics");
    // recorded from the tenth second on
    for n in 30_000..30_600 {
        line.sound(16 * n, &FRAME).expect("handed over");
        assert_eq!(line.poll_notice(), None, "{n}");
    }
    drop(held);
    assert_eq!(aside.lost(), [0; 3]);
    assert_eq!(aside.end().expect("no failure").expect("a disk").ticks.len(), 600);
}
