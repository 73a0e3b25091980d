//! Reads a take: its header, and its events in order.
//!
//! The state before a reload is returned as its record, because a take holds only a hash of it. Foreign topics and
//! those for viewers are skipped by name, so that a take with additions still replays.

use super::header::{Header, META};
use super::next_version::{self, NextModel};
use super::records::{Energy, Hand, Hashed, Lost, Ordered, Reloaded, Rt};
use super::source::{End, Item, Source, torn};
use super::{cdr, topic};
use crate::engine::Change;
use crate::engine::ManualEvent;
use crate::frame::{Cause, DeviceFrame, ForceFrame};
use crate::guard::Order;
use crate::profile::Profile;
use ca_io::error::FileError;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// One event in a take.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A frame that was checked.
    Device(usize, Box<DeviceFrame>),
    /// A frame that was sent.
    Force(usize, Box<ForceFrame>),
    /// Parameters changed before this tick.
    Change(u64, Change),
    /// The scene was loaded again.
    Reload(Reloaded),
    /// Another version of the model plays from this tick on.
    Model(u64, Box<NextModel>),
    /// Forces were armed, disarmed or tripped before this tick, of one device or all.
    Order(u64, Option<u32>, Order),
    /// Input without a device acted before this tick.
    Hand(u64, ManualEvent),
    /// A device described itself before this tick.
    Profile(u64, usize, Box<Profile>),
    /// A hash of the state.
    Hash(Hashed),
    /// The energy ledger.
    Energy(Energy),
    /// Sound, interleaved, from this tick on.
    Sound(u64, Vec<f64>),
    /// Data is missing here.
    Lost(Lost),
    /// State of the real-time thread.
    Rt(Rt),
    /// An event without effect on a replay.
    View,
}

/// A take.
#[derive(Clone, Debug)]
pub struct Take {
    /// Path of the file.
    pub path: PathBuf,
    /// Header before the first frame.
    pub header: Header,
}

impl Take {
    /// Opens the take at `path`, finished or not. A file that was cut is read as far as possible.
    ///
    /// # Errors
    /// If the file cannot be read or is not a take.
    pub fn open(path: impl AsRef<Path>) -> Result<Take, FileError> {
        let path = path.as_ref();
        let name = |e: FileError| e.file(path.display());
        let mut files = Vec::new();
        let mut meta = None;
        // attachments and metadata come before the first message
        let mut source = Source::open(path)?;
        for item in source.by_ref() {
            match item? {
                Item::Attachment { name, data, .. } => files.push((name, String::from_utf8_lossy(&data).into_owned())),
                Item::Metadata(m) if m.name == META => {
                    meta = Some(m.metadata);
                    break;
                }
                Item::Metadata(_) => {}
                Item::Message { .. } => break,
            }
        }
        let Some(meta) = meta else {
            let what = match source.end().and_then(End::early) {
                Some((why, _)) => format!("it ends before its first frame: {why}"),
                None => "this is an MCAP file, but not a take of `ca`".into(),
            };
            return Err(name(FileError::format(what).fix("give a take that `ca` recorded")));
        };
        let header = Header::read(&files, &meta).map_err(name)?;
        Ok(Take { path: path.to_owned(), header })
    }

    /// Returns an iterator over the events, in order.
    ///
    /// # Errors
    /// If the file cannot be read again.
    pub fn events(&self) -> Result<Events, FileError> {
        let mut ports = HashMap::new();
        for (k, s) in self.header.setups.iter().enumerate() {
            ports.insert(topic::device(&s.device), (k, false));
            ports.insert(topic::force(&s.device), (k, true));
        }
        Ok(Events { source: Source::open(&self.path)?, path: self.path.clone(), ports })
    }
}

/// Iterator over the events of a take.
pub struct Events {
    source: Source,
    path: PathBuf,
    /// Number of the device by topic of its frames, and whether they are forces.
    ports: HashMap<String, (usize, bool)>,
}

impl Events {
    /// Returns how the file ended; `None` before its end.
    pub fn end(&self) -> Option<&End> {
        self.source.end()
    }

    /// Decodes a message; `None` where it does not match its topic.
    fn event(&self, name: &str, data: &[u8]) -> Option<Event> {
        if let Some((k, force)) = self.ports.get(name) {
            return Some(if *force {
                Event::Force(*k, Box::new(cdr::record(data).filter(ForceFrame::has_this_layout)?))
            } else {
                // frames of another layout too: they are recorded as they came
                Event::Device(*k, Box::new(cdr::record::<DeviceFrame>(data)?))
            });
        }
        Some(match name {
            topic::CHANGE => {
                let (tick, change) = cdr::read_change(data)?;
                Event::Change(tick, change)
            }
            topic::RELOAD => Event::Reload(cdr::record(data)?),
            topic::MODEL => {
                let (tick, model) = next_version::read(data)?;
                Event::Model(tick, Box::new(model))
            }
            topic::ORDER => {
                let o: Ordered = cdr::record(data)?;
                let order = match o.order {
                    0 => Order::Arm,
                    1 => Order::Disarm,
                    2 => Order::Trip(Cause::read(u16::try_from(o.cause).ok()?)),
                    _ => return None,
                };
                Event::Order(o.tick, (o.port != Ordered::ALL).then_some(o.port), order)
            }
            topic::HAND => {
                let hand: Hand = cdr::record(data)?;
                Event::Hand(hand.tick, hand.event()?)
            }
            topic::PROFILE => {
                let mut r = cdr::In::new(data)?;
                let (tick, port) = (r.get::<u64>()?, r.get::<u32>()? as usize);
                Event::Profile(tick, port, Box::new(Profile::read(&r.text()?, topic::PROFILE).ok()?))
            }
            topic::HASH => Event::Hash(cdr::record(data)?),
            topic::ENERGY => Event::Energy(cdr::record(data)?),
            topic::LOST => Event::Lost(cdr::record(data)?),
            topic::RT => Event::Rt(cdr::record(data)?),
            topic::SOUND => {
                let mut r = cdr::In::new(data)?;
                let (tick, _, _) = (r.get::<u64>()?, r.get::<u32>()?, r.get::<u32>()?);
                Event::Sound(tick, r.list()?)
            }
            _ => Event::View,
        })
    }
}

impl Iterator for Events {
    type Item = Result<Event, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            match self.source.next()? {
                Err(e) => return Some(Err(e)),
                Ok(Item::Message { channel, sequence, data, .. }) => {
                    let event = self.event(&channel.topic, &data);
                    let e = || torn(&channel.topic, sequence).file(self.path.display());
                    return Some(event.ok_or_else(e));
                }
                Ok(_) => {}
            }
        }
    }
}
