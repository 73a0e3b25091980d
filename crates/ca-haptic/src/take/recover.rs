//! Rebuilds a take that was cut off: the same messages, with an index.
//!
//! Complete messages are copied one by one, under the same names and numbers, into a new file. The old one is left as
//! it is, as evidence of the crash. Like the old one, the new file is readable by its owner only.

use super::options;
use super::source::{End, Item, Source};
use super::write::failed;
use ca_io::atomic_file::AtomicFile;
use ca_io::error::FileError;
use mcap::{Attachment, McapResult, Message, Writer};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Result of a recovery.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovered {
    /// Messages in the new file.
    pub messages: u64,
    /// Time from the first to the last of them \[s\].
    pub seconds: f64,
    /// Attachments in the new file.
    pub attachments: u64,
    /// Reason why the old file ended early, and the unusable bytes at its end; `None` if it was complete.
    pub cut: Option<(String, u64)>,
    /// True if it ended at corrupt bytes, with more behind them.
    pub damaged: bool,
}

/// Copies the complete items of the file `from` to `to`.
///
/// # Errors
/// If nothing of it can be read, or the new file cannot be written.
pub fn recover(from: impl AsRef<Path>, to: impl AsRef<Path>) -> Result<Recovered, FileError> {
    let (from, to) = (from.as_ref(), to.as_ref());
    let mut source = Source::open(from)?;
    let staged = AtomicFile::create_private(to)?;
    let file = BufWriter::with_capacity(1 << 16, staged.handle()?);
    let mut out = options().create(file).map_err(|e| failed(to, &e))?;
    let mut reported = Recovered { messages: 0, seconds: 0.0, attachments: 0, cut: None, damaged: false };
    let mut first = None;
    for item in source.by_ref() {
        let item = item?;
        if let Item::Message { time, .. } = &item {
            reported.messages += 1;
            let begin = *first.get_or_insert(*time);
            reported.seconds = reported.seconds.max(time.saturating_sub(begin) as f64 * 1e-9);
        }
        reported.attachments += u64::from(matches!(item, Item::Attachment { .. }));
        copy(&mut out, item).map_err(|e| failed(to, &e))?;
    }
    out.finish().map_err(|e| failed(to, &e))?;
    out.into_inner().into_inner().map_err(|e| FileError::io(to, "it cannot be written", e.error()))?;
    staged.commit()?;
    reported.damaged = matches!(source.end(), Some(End::Damaged(..)));
    reported.cut = source.end().and_then(End::early).map(|(why, bytes)| (why.to_owned(), bytes));
    Ok(reported)
}

fn copy(out: &mut Writer<BufWriter<File>>, item: Item) -> McapResult<()> {
    match item {
        Item::Message { channel, sequence, time, data } => {
            out.write(&Message { channel, sequence, log_time: time, publish_time: time, data: data.into() })
        }
        Item::Attachment { name, media, time, data } => {
            let (log_time, create_time) = (time, time);
            out.attach(&Attachment { log_time, create_time, name, media_type: media, data: data.into() })
        }
        Item::Metadata(m) => out.write_metadata(&m),
    }
}
