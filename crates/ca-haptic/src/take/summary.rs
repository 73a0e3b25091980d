//! Summary of a take: topics, length, losses, faults.
//!
//! It counts the messages themselves rather than trusting the index, which a truncated take lacks.

use super::read::Take;
use super::source::{End, Item, Source};
use super::{cdr, records::Lost, topic};
use crate::frame::{Cause, ForceFrame, Mode};
use ca_io::error::FileError;
use std::collections::BTreeMap;

/// One topic.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topic {
    /// Schema of its messages.
    pub schema: String,
    /// Encoding of its messages.
    pub encoding: String,
    /// Number of messages.
    pub messages: u64,
    /// Bytes of messages.
    pub bytes: u64,
    /// Times of the first and last message, since 1970 \[ns\].
    pub span: [u64; 2],
}

impl Topic {
    /// Returns the messages a second, if there are two or more.
    pub fn rate(&self) -> Option<f64> {
        let t = self.span[1].saturating_sub(self.span[0]) as f64 * 1e-9;
        (self.messages > 1 && t > 0.0).then(|| (self.messages - 1) as f64 / t)
    }
}

/// A fault that ended forces.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Name of the device.
    pub device: String,
    /// Time \[s\].
    pub time: f64,
    /// Its cause.
    pub cause: Cause,
}

/// Summary of a take.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Topics by name.
    pub topics: BTreeMap<String, Topic>,
    /// Attachments: name and bytes.
    pub attachments: Vec<(String, u64)>,
    /// Length \[s\].
    pub seconds: f64,
    /// Losses of records, sound samples and views.
    pub lost: [u64; 3],
    /// Faults, in order.
    pub faults: Vec<Fault>,
    /// End of the file.
    pub end: End,
}

impl Take {
    /// Reads the whole take and summarises it.
    ///
    /// # Errors
    /// If the file cannot be read again.
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
