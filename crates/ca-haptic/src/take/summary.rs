//! What is in a take, in numbers: topics, length, losses, faults.
//!
//! Decides to count what is there rather than to believe the index, which a take that was cut off does not have.

use super::read::Take;
use super::source::{End, Item, Source};
use super::{cdr, flat::Lost, topic};
use crate::frame::{Cause, ForceFrame, Mode};
use ca_io::error::FileError;
use std::collections::BTreeMap;

/// One topic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topic {
    /// what its messages are
    pub schema: String,
    /// how they are written
    pub encoding: String,
    /// messages
    pub messages: u64,
    /// bytes of messages
    pub bytes: u64,
    /// times of first and last, since 1970 \[ns\]
    pub span: [u64; 2],
}

impl Topic {
    /// Messages a second, where there are two or more.
    pub fn rate(&self) -> Option<f64> {
        let t = self.span[1].saturating_sub(self.span[0]) as f64 * 1e-9;
        (self.messages > 1 && t > 0.0).then(|| (self.messages - 1) as f64 / t)
    }
}

/// Forces that ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// name of the device
    pub device: String,
    /// when \[s\]
    pub time: f64,
    /// why
    pub cause: Cause,
}

/// What is in a take.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// topics by name
    pub topics: BTreeMap<String, Topic>,
    /// attachments: name and bytes
    pub attachments: Vec<(String, u64)>,
    /// length \[s\]
    pub seconds: f64,
    /// what found no room: records, sound samples, views
    pub lost: [u64; 3],
    /// faults, in order
    pub faults: Vec<Fault>,
    /// how the file ended
    pub end: End,
}

impl Take {
    /// Goes through all of it.
    ///
    /// # Errors
    /// Where the file cannot be read again.
    pub fn summary(&self) -> Result<Summary, FileError> {
        let mut source = Source::open(&self.path)?;
        let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
        let (mut attachments, mut faults, mut lost, mut last) = (Vec::new(), Vec::new(), [0; 3], self.header.began_ns);
        let outs: Vec<String> = self.header.setups.iter().map(|s| topic::force(&s.device)).collect();
        let mut modes = vec![Mode::Off; outs.len()];
        for item in source.by_ref() {
            let (channel, time, data) = match item? {
                Item::Message { channel, time, data, .. } => (channel, time, data),
                Item::Attachment { name, data, .. } => {
                    attachments.push((name, data.len() as u64));
                    continue;
                }
                Item::Metadata(_) => continue,
            };
            let t = topics.entry(channel.topic.clone()).or_insert_with(|| Topic {
                schema: channel.schema.as_ref().map(|s| s.name.clone()).unwrap_or_default(),
                encoding: channel.message_encoding.clone(),
                span: [time; 2],
                ..Topic::default()
            });
            t.messages += 1;
            t.bytes += data.len() as u64;
            t.span = [t.span[0].min(time), t.span[1].max(time)];
            last = last.max(time);
            if channel.topic == topic::LOST {
                if let Some(l) = cdr::record::<Lost>(&data) {
                    let more = [l.records, l.samples, l.views];
                    lost = std::array::from_fn(|k| u64::saturating_add(lost[k], more[k]));
                }
            }
            if let Some(k) = outs.iter().position(|o| *o == channel.topic) {
                if let Some(f) = cdr::record::<ForceFrame>(&data) {
                    let mode = Mode::read(f.mode);
                    if mode == Mode::Fault && modes[k] != Mode::Fault {
                        let device = self.header.setups[k].device.clone();
                        let time = f.tick as f64 / self.header.rate;
                        faults.push(Fault { device, time, cause: Cause::read(f.cause) });
                    }
                    modes[k] = mode;
                }
            }
        }
        let seconds = last.saturating_sub(self.header.began_ns) as f64 * 1e-9;
        let end = source.end().cloned().unwrap_or(End::Whole);
        Ok(Summary { topics, attachments, seconds, lost, faults, end })
    }
}
