//! Runs a sink on a separate thread.
//!
//! A slow disk must delay neither `ca disarm` nor another file, so the recorder hands data ended and continues, whatever
//! a sink does. [`BufferLimits`] limits the waiting data, in seconds of the performance and in bytes. Beyond the
//! limits, frames, sound and pictures are left out of this file only, counted, and reported at the gap. Records that
//! affect everything after them (changes, orders, reloads) are rare and always handed ended. After an overflow, data is
//! accepted only when half of the buffer is free, because one long gap is clearer than a thousand short ones. An
//! earlier design let data wait in the rings: one slow file made gaps in all files, and the recorder could not report
//! them.
//!
//! The thread asks for a larger share of the cores instead of real time. A real-time writer with a backlog would block
//! a core, and the kernel would throttle the engine with it.

use super::sink::{Notice, Sink, SinkStreams, missing};
use super::summary::StatsSnapshot;
use crate::record::Record;
use crate::rt::{self, Granted, RtRequest};
use crate::version::Version;
use ca_core::Scene;
use ca_io::error::FileError;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Limits of the data that waits for a sink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BufferLimits {
    /// Sound samples per second, to convert ticks to seconds.
    pub rate: f64,
    /// Longest delay \[s\].
    pub seconds: f64,
    /// Largest memory \[bytes\].
    pub bytes: usize,
}

impl BufferLimits {
    /// Returns 30 s and 256 MB (2²⁸ bytes), which is enough for 30 s of one device and its sound.
    pub fn of(scene: &Scene) -> BufferLimits {
        BufferLimits { rate: scene.rate, seconds: 30.0, bytes: 1 << 28 }
    }
}

/// Delay from which a sink is reported \[s\].
const LATE: f64 = 2.0;

enum Message {
    Record(Box<Record>),
    Sound(u64, Vec<f64>),
    View(u64, Vec<f64>),
    Swapped(u64, Arc<Version>),
    StatsSnapshot(StatsSnapshot),
    Notice(Notice),
    End,
}

impl Message {
    /// Returns its tick, if that shows the progress of the sink.
    fn tick(&self) -> Option<u64> {
        match self {
            Message::Record(r) => Some(r.tick()),
            Message::Sound(tick, _) | Message::View(tick, _) | Message::Swapped(tick, _) => Some(*tick),
            Message::StatsSnapshot(_) | Message::Notice(_) | Message::End => None,
        }
    }

    fn bytes(&self) -> usize {
        size_of::<Message>()
            + match self {
                Message::Record(_) => size_of::<Record>(),
                Message::Sound(_, v) | Message::View(_, v) => size_of_val(&v[..]),
                Message::Notice(h) => h.text.len(),
                // not allocated for this message
                Message::Swapped(..) | Message::StatsSnapshot(_) | Message::End => 0,
            }
    }
}

#[derive(Default)]
struct Shared {
    /// Number of waiting messages, and their bytes.
    waiting: AtomicUsize,
    bytes: AtomicUsize,
    /// Tick written last.
    done: AtomicU64,
    /// Records, sound samples and pictures that did not fit.
    lost: [AtomicU64; 3],
    ended: AtomicBool,
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

/// Sets `ended` when the thread ends in any way, so that no other thread waits for it.
struct EndGuard<'a>(&'a Shared);

impl Drop for EndGuard<'_> {
    fn drop(&mut self) {
        self.0.ended.store(true, Relaxed);
    }
}

/// The recorder's side.
pub struct SinkHandle {
    name: String,
    to: Sender<Message>,
    shared: Arc<Shared>,
    streams: SinkStreams,
    limits: BufferLimits,
    /// Latest tick received.
    newest: u64,
    /// True from an overflow until half of the buffer is free again.
    full: bool,
    /// Records left out since the last one handed ended.
    missing: u64,
    /// Last report: losses, tick, and the delay from which the next report is due \[s\].
    reported: [u64; 3],
    reported_at: u64,
    next: f64,
}

/// The owner's side.
pub struct AsyncSink<T> {
    to: Sender<Message>,
    shared: Arc<Shared>,
    granted: Granted,
    thread: Option<JoinHandle<Option<T>>>,
}

impl<T> Drop for AsyncSink<T> {
    /// Waits for a thread that was not ended: its sink must remove a partial file before the process ends.
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = self.to.send(Message::End);
            let _ = thread.join();
        }
    }
}

impl<T: Sink + Send + 'static> AsyncSink<T> {
    /// Moves a sink to a thread with this name, which asks the system for `request`.
    ///
    /// # Errors
    /// If no thread can be started.
    pub fn start(
        name: &str,
        mut sink: T,
        limits: BufferLimits,
        request: RtRequest,
    ) -> Result<(SinkHandle, AsyncSink<T>), FileError> {
        let (to, from) = channel();
        let (tell, granted) = channel();
        let shared = Arc::new(Shared::default());
        let (of, streams) = (shared.clone(), sink.streams());
        let thread = Builder::new()
            .name(name.into())
            .spawn(move || {
                let _over = EndGuard(&of);
                // dropped before `_over`, so that a later send fails instead of being ignored
                let from = from;
                let _ = tell.send(rt::ask(request));
                match work(&mut sink, &from, &of) {
                    Ok(()) => Some(sink),
                    Err(e) => {
                        *of.failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(e);
                        None
                    }
                }
            })
            .map_err(|e| FileError::content(format!("cannot start a writer thread: {e}")))?;
        let line = SinkHandle {
            name: name.strip_prefix("ca ").unwrap_or(name).into(),
            to: to.clone(),
            shared: shared.clone(),
            streams,
            limits,
            newest: 0,
            full: false,
            missing: 0,
            reported: [0; 3],
            reported_at: 0,
            next: LATE,
        };
        Ok((line, AsyncSink { to, shared, granted: granted.recv().unwrap_or_default(), thread: Some(thread) }))
    }

    /// Returns what the system granted its thread.
    pub fn granted(&self) -> &Granted {
        &self.granted
    }

    /// Returns the records, sound samples and pictures that did not fit in the buffer of this sink.
    pub fn lost(&self) -> [u64; 3] {
        self.shared.lost()
    }

    /// Ends the sink, and waits at most for `patience` until everything is written. A blocked thread is left behind.
    /// Use this if the sink is not needed again.
    pub fn end_within(mut self, patience: Duration) {
        let _ = self.to.send(Message::End);
        let end = Instant::now() + patience;
        while !self.shared.ended.load(Relaxed) {
            if Instant::now() > end {
                self.thread = None;
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Returns the sink once everything handed ended is written; `None` if it failed and the recorder has reported that.
    ///
    /// # Errors
    /// If the sink failed and the recorder has not reported it.
    pub fn end(mut self) -> Result<Option<T>, FileError> {
        // after a failure, the receiver is gone
        let _ = self.to.send(Message::End);
        let sink = self.thread.take().and_then(|t| t.join().ok()).flatten();
        self.shared.failed().map_or(Ok(sink), Err)
    }
}

fn work(sink: &mut impl Sink, from: &Receiver<Message>, shared: &Shared) -> Result<(), FileError> {
    while let Ok(thing) = from.recv() {
        let (tick, bytes) = (thing.tick(), thing.bytes());
        match thing {
            Message::Record(r) => sink.record(&r)?,
            Message::Sound(tick, frames) => sink.sound(tick, &frames)?,
            Message::View(tick, x) => sink.view(tick, &x)?,
            Message::Swapped(tick, version) => sink.swapped(tick, &version)?,
            Message::StatsSnapshot(p) => sink.snapshot(&p)?,
            Message::Notice(h) => sink.notice(&h)?,
            Message::End => break,
        }
        if let Some(tick) = tick {
            shared.done.fetch_max(tick, Relaxed);
        }
        shared.bytes.fetch_sub(bytes, Relaxed);
        shared.waiting.fetch_sub(1, Relaxed);
    }
    Ok(())
}

impl SinkHandle {
    fn put(&mut self, thing: Message) -> Result<(), FileError> {
        self.newest = self.newest.max(thing.tick().unwrap_or(0));
        // without waiting messages the sink is up to date, even after a long pause
        if self.shared.waiting.fetch_add(1, Relaxed) == 0 {
            self.shared.done.fetch_max(self.newest, Relaxed);
        }
        self.shared.bytes.fetch_add(thing.bytes(), Relaxed);
        let gone = || FileError::content("the writer thread stopped unexpectedly");
        self.to.send(thing).map_err(|_| self.shared.failed().unwrap_or_else(gone))
    }

    /// Returns the delay of the sink \[s\].
    fn behind(&self) -> f64 {
        if self.shared.waiting.load(Relaxed) == 0 {
            return 0.0;
        }
        self.newest.saturating_sub(self.shared.done.load(Relaxed)) as f64 / self.limits.rate
    }

    /// Returns true if data of `tick` may wait too. Otherwise counts `n` of this kind as lost.
    fn has_capacity(&mut self, tick: u64, kind: usize, n: u64) -> bool {
        // the thread has ended, and the next send returns the reason
        if self.shared.ended.load(Relaxed) {
            return true;
        }
        self.newest = self.newest.max(tick);
        let part = if self.full { 0.5 } else { 1.0 };
        let bytes = self.shared.bytes.load(Relaxed) as f64;
        self.full = self.behind() >= part * self.limits.seconds || bytes >= part * self.limits.bytes as f64;
        if self.full {
            self.shared.lost[kind].fetch_add(n, Relaxed);
        }
        !self.full
    }
}

impl Sink for SinkHandle {
    fn streams(&self) -> SinkStreams {
        self.streams
    }

    fn lost(&self) -> [u64; 3] {
        self.shared.lost()
    }

    fn poll_notice(&mut self) -> Option<(bool, String)> {
        let lost = self.shared.lost();
        let first = self.reported == [0; 3];
        if lost != self.reported && (first || (self.newest - self.reported_at) as f64 >= self.limits.rate) {
            (self.reported, self.reported_at) = (lost, self.newest);
            let why = "writing is slower than playing; write to a faster disk, or close other programs";
            return Some((true, format!("{}: {} lost so far, because {why}", self.name, missing(lost))));
        }
        let behind = self.behind();
        // beyond the limit, the losses are reported
        if behind >= self.next && behind < self.limits.seconds {
            self.next = 2.0 * behind;
            let most = self.limits.seconds;
            return Some((true, format!("{}: written {behind:.1} s late; data are lost beyond {most} s", self.name)));
        }
        if self.next > LATE && behind < 0.5 * LATE {
            self.next = LATE;
            return Some((false, format!("{}: written in time again", self.name)));
        }
        None
    }

    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        if !self.streams.records {
            return Ok(());
        }
        let tick = record.tick();
        let decides = matches!(
            record,
            Record::Retired { .. }
                | Record::Order { .. }
                | Record::Manual { .. }
                | Record::Swapped { .. }
                | Record::Marked { .. }
                | Record::Lost { .. }
        );
        if !decides && !self.has_capacity(tick, 0, 1) {
            self.missing += 1;
            return Ok(());
        }
        if self.missing > 0 {
            let records = std::mem::take(&mut self.missing);
            self.put(Message::Record(Box::new(Record::Lost { tick, records })))?;
        }
        self.put(Message::Record(Box::new(record.clone())))
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        if self.streams.sound && self.has_capacity(tick, 1, frames.len() as u64) {
            self.put(Message::Sound(tick, frames.to_vec()))?;
        }
        Ok(())
    }

    fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        if self.streams.views && self.has_capacity(tick, 2, 1) {
            self.put(Message::View(tick, x.to_vec()))?;
        }
        Ok(())
    }

    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        self.put(Message::Swapped(tick, version.clone()))
    }

    fn snapshot(&mut self, snapshot: &StatsSnapshot) -> Result<(), FileError> {
        if self.streams.stats { self.put(Message::StatsSnapshot(*snapshot)) } else { Ok(()) }
    }

    fn notice(&mut self, notice: &Notice) -> Result<(), FileError> {
        // messages are rare, but a blocked terminal must not fill the memory
        let full = self.shared.bytes.load(Relaxed) >= 2 * self.limits.bytes && !self.shared.ended.load(Relaxed);
        if full { Ok(()) } else { self.put(Message::Notice(notice.clone())) }
    }
}

#[cfg(test)]
mod tests;
