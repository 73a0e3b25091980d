//! Writes a take: one MCAP file per performance.
//!
//! The writer does not seek. Each chunk is built in memory and written whole, at least every 200 ms, so that the file
//! of a killed writer ends with a whole chunk and reads up to there without repair. Everything that determines the
//! future (frames as checked, changes, orders, reloads) is written in order and numbered.
//!
//! Sound is stored as the engine made it, 64 bits, in blocks of 40 ms, so that a replay can be compared to the bit even
//! if the file ends early. A WAV attached at the end would be missing from exactly the takes that need analysis. This
//! takes 1.4 GB an hour and channel at 48 kHz. A 16-bit copy is for listening.
//!
//! The file has its final name from the start. A performance cannot be repeated, so an existing file is never
//! overwritten, and an unfinished one is never removed, unless its performance did not begin.

mod channels;
mod views;

use super::header::{Header, META};
use super::records::{Energy, Hand, Hashed, Lost, Ordered, Reloaded, Rt};
use super::{cdr, next_version, options};
use crate::engine::Retired;
use crate::frame::{Cause, DeviceFrame, ForceFrame, Mode};
use crate::guard::Order;
use crate::record::Record;
use crate::version::Version;
use ca_core::Scene;
use ca_core::internal::state::shape;
use ca_io::atomic_file::new_file;
use ca_io::error::{FileError, FileErrorKind};
use channels::{DeviceChannels, Ids};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{Attachment, McapError, Writer};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
pub use views::Level;
use views::Picture;

/// Length of a block of sound \[s\].
const BLOCK: f64 = 0.04;
/// Rate of the joint messages \[Hz\].
const JOINTS: f64 = 100.0;
/// Longest time between chunks, and the most that a killed process loses.
const CHUNK: Duration = Duration::from_millis(200);

/// Result of writing a take.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finished {
    /// Path of the file.
    pub path: PathBuf,
    /// Number of messages.
    pub messages: u64,
    /// Length \[s\].
    pub seconds: f64,
    /// Frames, events and sound samples that did not fit.
    pub lost: u64,
}

/// Writer of a take.
pub struct TakeWriter {
    out: Writer<NoSeek<BufWriter<File>>>,
    path: PathBuf,
    header: Header,
    hands: Vec<DeviceChannels>,
    params: Vec<String>,
    ids: Ids,
    picture: Picture,
    /// Tick of the first picture of this version of the model.
    pictures_from: u64,
    data: Vec<u8>,
    sequence: u32,
    tick: u64,
    joints_due: u64,
    sound: Vec<f64>,
    sound_tick: u64,
    flushed: Instant,
    /// Losses reported so far: records, sound samples, views.
    lost: [u64; 3],
    reported: Finished,
}

impl TakeWriter {
    /// Creates the file at `path`, with everything that a replay needs. An existing file is not changed.
    ///
    /// # Errors
    /// If the file exists or cannot be written.
    pub fn create(path: impl AsRef<Path>, header: &Header, scene: &Scene) -> Result<TakeWriter, FileError> {
        let path = path.as_ref().to_owned();
        let file = new_file(&path, 0o600).map_err(|e| {
            let fix = match e.kind() {
                std::io::ErrorKind::AlreadyExists => "choose another name: takes are never overwritten",
                std::io::ErrorKind::NotFound => "make the directory first",
                _ => "",
            };
            FileError::io(&path, "it cannot be created", &e).fix(fix)
        })?;
        let begin = || {
            let options = options().compression_level(1).disable_seeking(true);
            let mut out = options.create(NoSeek::new(BufWriter::with_capacity(1 << 16, file)))?;
            let (files, metadata) = header.write();
            for f in files {
                out.attach(&Attachment {
                    log_time: header.began_ns,
                    create_time: header.began_ns,
                    name: f.name,
                    media_type: f.media.into(),
                    data: f.data.into_bytes().into(),
                })?;
            }
            out.write_metadata(&mcap::records::Metadata { name: META.into(), metadata })?;
            let (ids, hands) = channels::declare(&mut out, header, scene)?;
            out.flush()?;
            Ok((out, ids, hands))
        };
        let (out, ids, hands) = begin().map_err(|e| failed(&path, &e))?;
        Ok(TakeWriter {
            out,
            reported: Finished { path: path.clone(), ..Finished::default() },
            path,
            header: header.clone(),
            hands,
            params: scene.live.params.iter().map(|p| p.name.clone()).collect(),
            ids,
            picture: Picture::new(scene),
            pictures_from: 0,
            data: Vec::new(),
            sequence: 0,
            tick: 0,
            joints_due: 0,
            sound: Vec::new(),
            sound_tick: 0,
            flushed: Instant::now(),
            lost: [0; 3],
        })
    }

    /// Writes the message in `self.data` at a tick, and closes the chunk when due.
    fn put(&mut self, channel: u16, tick: u64) -> Result<(), FileError> {
        self.sequence = self.sequence.wrapping_add(1);
        let time = self.header.time(tick);
        let head = MessageHeader { channel_id: channel, sequence: self.sequence, log_time: time, publish_time: time };
        self.reported.messages += 1;
        self.reported.seconds = self.reported.seconds.max(tick as f64 / self.header.rate);
        let mut done = self.out.write_to_known_channel(&head, &self.data);
        if done.is_ok() && self.flushed.elapsed() >= CHUNK {
            done = self.out.flush();
            self.flushed = Instant::now();
        }
        done.map_err(|e| failed(&self.path, &e))
    }

    /// Writes one event.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn record(&mut self, record: &Record) -> Result<(), FileError> {
        match *record {
            Record::Device { port, ref frame } => self.device(port as usize, frame),
            Record::Force { port, ref frame } => self.force(port as usize, frame),
            Record::Retired { tick, retired: Retired::Change(ref change) } => {
                self.tick = tick;
                cdr::change(&mut self.data, tick, change);
                self.put(self.ids.change, tick)?;
                for &(p, v) in &change.params {
                    let name = self.params.get(p as usize).map_or("?", String::as_str);
                    cdr::Out::new(&mut self.data).put(tick).put(v).text(name);
                    self.put(self.ids.param, tick)?;
                }
                Ok(())
            }
            Record::Retired { tick, retired: Retired::State(ref old) } => {
                self.tick = tick;
                let [places, coefs] = shape(old).map(|n| n as u32);
                cdr::body(&mut self.data, &Reloaded { tick, bits: old.bits(), places, coefs });
                self.put(self.ids.reload, tick)?;
                self.log(tick, Level::Info, "scene", "reset to its state at load")
            }
            Record::Retired { tick, retired: Retired::Port(ref old) } => {
                self.tick = tick;
                cdr::Out::new(&mut self.data).put(tick).put(old.which).text(&old.profile.write());
                self.put(self.ids.profile, tick)?;
                let name = self.hands.get(old.which as usize).map_or_else(String::new, |h| h.name.clone());
                let p = &old.profile;
                let said = format!(
                    "{}: {} degrees of freedom, {} per force vector, at most {} N",
                    p.title, p.dof, p.axes, p.force
                );
                self.log(tick, Level::Info, &name, &said)
            }
            Record::Order { tick, port, order } => {
                self.tick = tick;
                let (number, cause) = match order {
                    Order::Arm => (0, Cause::None),
                    Order::Disarm => (1, Cause::None),
                    Order::Trip(cause) => (2, cause),
                };
                let cause = cause as u32;
                let port = port.unwrap_or(Ordered::ALL);
                cdr::body(&mut self.data, &Ordered { tick, port, order: number, cause, reserved: 0 });
                self.put(self.ids.order, tick)
            }
            Record::Manual { tick, event, .. } => {
                self.tick = tick;
                cdr::body(&mut self.data, &Hand::new(tick, event));
                self.put(self.ids.hand, tick)
            }
            Record::Lost { tick, records } => {
                self.tick = tick;
                self.lost(records, 0, 0)
            }
            // a wait is only logged, a gesture that ended is in the record of its end, and `swapped` writes versions
            Record::Waiting { .. }
            | Record::Swapped { .. }
            | Record::Retired { retired: Retired::Gesture(_) | Retired::Swap(_), .. } => Ok(()),
            Record::Marked { tick, bits } | Record::Hash { tick, bits } => {
                self.tick = tick;
                cdr::body(&mut self.data, &Hashed { tick, bits });
                self.put(self.ids.hash, tick)
            }
            Record::Energy { tick, ref balance } => {
                self.tick = tick;
                cdr::body(&mut self.data, &Energy::new(tick, balance));
                self.put(self.ids.energy, tick)
            }
        }
    }

    /// Writes that another version of the model plays from `tick` on.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn swapped(&mut self, tick: u64, version: &Version) -> Result<(), FileError> {
        self.tick = tick;
        next_version::write(&mut self.data, tick, version);
        self.put(self.ids.model, tick)?;
        let scene = &version.scene;
        self.params = scene.live.params.iter().map(|p| p.name.clone()).collect();
        for h in &mut self.hands {
            h.joints = (0..h.joints.len()).map(|k| views::joint(scene, &h.name, k)).collect();
        }
        (self.picture, self.pictures_from) = (Picture::new(scene), tick);
        self.log(tick, Level::Info, "model", "another version plays")
    }

    fn device(&mut self, port: usize, frame: &DeviceFrame) -> Result<(), FileError> {
        let Some(hand) = self.hands.get_mut(port) else { return Ok(()) };
        hand.at.0 = frame.pos;
        let channel = hand.take;
        self.tick = frame.tick;
        cdr::body(&mut self.data, frame);
        self.put(channel, frame.tick)
    }

    fn force(&mut self, port: usize, frame: &ForceFrame) -> Result<(), FileError> {
        let Some(hand) = self.hands.get_mut(port) else { return Ok(()) };
        let (channel, now) = (hand.give, (frame.mode, frame.cause));
        let before = std::mem::replace(&mut hand.said, now);
        hand.at.1 = frame.force;
        self.tick = frame.tick;
        cdr::body(&mut self.data, frame);
        self.put(channel, frame.tick)?;
        if before != now {
            let name = self.hands[port].name.clone();
            let (mode, cause) = (Mode::read(frame.mode), Cause::read(frame.cause));
            let level = if matches!(mode, Mode::Fault | Mode::Damp) { Level::Error } else { Level::Info };
            let why = if cause == Cause::None { String::new() } else { format!(": {}", cause.name()) };
            self.log(frame.tick, level, &name, &format!("forces {}{why}", mode.name()))?;
        }
        if port + 1 == self.hands.len() && frame.tick >= self.joints_due {
            self.joints_due = frame.tick + (self.header.rate / JOINTS) as u64;
            let all = self.hands.iter().flat_map(|h| {
                let numbers = h.at.0.iter().zip(&h.at.1);
                h.joints.iter().zip(numbers).map(|(name, (x, f))| (name.as_str(), *x, f64::from(*f)))
            });
            let message = views::joints(self.header.time(frame.tick), all);
            views::bytes(&mut self.data, &message);
            self.put(self.ids.joints, frame.tick)?;
        }
        Ok(())
    }

    /// Writes interleaved sound whose first sample is at `tick`, and counts missing samples before it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn sound(&mut self, tick: u64, samples: &[f64]) -> Result<(), FileError> {
        let channels = self.header.channels.len();
        if channels == 0 {
            return Ok(());
        }
        let next = self.sound_tick + (self.sound.len() / channels) as u64;
        if tick != next {
            self.sound_block()?;
            self.lost(0, tick.saturating_sub(next) * channels as u64, 0)?;
            self.sound_tick = tick;
        }
        self.sound.extend_from_slice(samples);
        if self.sound.len() as f64 >= BLOCK * self.header.rate * channels as f64 {
            self.sound_block()?;
        }
        Ok(())
    }

    fn sound_block(&mut self) -> Result<(), FileError> {
        let channels = self.header.channels.len().max(1) as u32;
        let (tick, samples) = (self.sound_tick, std::mem::take(&mut self.sound));
        if samples.is_empty() {
            return Ok(());
        }
        cdr::Out::new(&mut self.data).put(tick).put(channels).put(0u32).list(&samples);
        self.put(self.ids.sound, tick)?;
        let heard = views::audio(self.header.time(tick), self.header.rate as u32, channels, &samples);
        views::bytes(&mut self.data, &heard);
        self.put(self.ids.audio, tick)?;
        self.sound_tick = tick + (samples.len() / channels as usize) as u64;
        self.sound = samples;
        self.sound.clear();
        Ok(())
    }

    /// Draws the scene from the displacements of its state; skips one from an earlier version of the model.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn view(&mut self, tick: u64, x: &[f64]) -> Result<(), FileError> {
        if tick < self.pictures_from {
            return Ok(());
        }
        let (masses, scene) = self.picture.draw(self.header.time(tick), x);
        views::bytes(&mut self.data, &masses);
        self.put(self.ids.masses, tick)?;
        views::bytes(&mut self.data, &scene);
        self.put(self.ids.scene, tick)
    }

    /// Writes the state of the real-time thread.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn stats(&mut self, rt: &Rt) -> Result<(), FileError> {
        cdr::body(&mut self.data, rt);
        self.put(self.ids.rt, rt.tick)
    }

    /// Writes a text message about `name`.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn log(&mut self, tick: u64, level: Level, name: &str, message: &str) -> Result<(), FileError> {
        let message = views::words(self.header.time(tick), level, name, message);
        views::bytes(&mut self.data, &message);
        self.put(self.ids.log, tick)
    }

    /// Records losses after the last record.
    fn lost(&mut self, records: u64, samples: u64, views: u64) -> Result<(), FileError> {
        if records + samples + views == 0 {
            return Ok(());
        }
        let [r, s, v] = self.lost;
        self.lost = [r + records, s + samples, v + views];
        self.reported.lost += records + samples;
        cdr::body(&mut self.data, &Lost { tick: self.tick, records, samples, views });
        self.put(self.ids.lost, self.tick)?;
        let what = format!("{records} records, {samples} sound samples and {views} views were lost: a buffer was full");
        self.log(self.tick, Level::Warning, "take", &what)
    }

    /// Writes everything so far to the disk, so that [`recover`](super::recover()) finds it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn flush(&mut self) -> Result<(), FileError> {
        self.flushed = Instant::now();
        self.out.flush().map_err(|e| failed(&self.path, &e))
    }

    /// Completes the file with its index and syncs it to the disk.
    ///
    /// `lost` has the total losses of records, sound samples and views; the end reports those not yet reported in
    /// place.
    ///
    /// # Errors
    /// If the file cannot be written; the part already written stays readable.
    pub fn finish(mut self, lost: [u64; 3]) -> Result<Finished, FileError> {
        self.sound_block()?;
        let [records, samples, views] = std::array::from_fn(|k| lost[k].saturating_sub(self.lost[k]));
        self.lost(records, samples, views)?;
        self.out.finish().map_err(|e| failed(&self.path, &e))?;
        let io = |e: &std::io::Error| FileError::io(&self.path, "it cannot be written", e);
        let file = self.out.into_inner().into_inner().into_inner().map_err(|e| io(e.error()))?;
        file.sync_all().map_err(|e| io(&e))?;
        Ok(self.reported)
    }
}

/// Converts an error of the MCAP library.
pub(super) fn failed(path: &Path, e: &McapError) -> FileError {
    match e {
        McapError::Io(e) => FileError::io(path, "it cannot be written", e),
        e => FileError::new(FileErrorKind::Io, ca_io::error::lower(&e.to_string())).file(path.display()),
    }
}
