//! Streams an MCAP file from its beginning to wherever it ends.
//!
//! Streaming keeps memory constant, whatever the length of a take. Each chunk is verified before any of it is used. A
//! file that ends early gives everything that was written whole, and is reported as cut. A file with corrupt bytes
//! gives everything before them, and is reported as damaged: what follows was played but is lost. The checksum over all
//! bytes of a finished file finds errors that no chunk shows.

use super::mcap_records;
use ca_io::error::{FileError, FileErrorKind};
use mcap::McapError;
use mcap::read::ChannelAccumulator;
use mcap::records::{Metadata, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Allowance for a chunk that compressed well \[bytes\].
const CHUNK: usize = 64 << 20;

/// One item of the file.
pub enum Item {
    Message {
        channel: Arc<mcap::Channel<'static>>,
        sequence: u32,
        /// Time since 1970 \[ns\].
        time: u64,
        data: Vec<u8>,
    },
    /// A file within the file.
    Attachment {
        name: String,
        media: String,
        /// Time since 1970 \[ns\].
        time: u64,
        data: Vec<u8>,
    },
    Metadata(Metadata),
}

/// End of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// The file is complete.
    Whole,
    /// The file ends early, as of a killed writer: the reason, and the number of unusable bytes at its end.
    Cut(String, u64),
    /// The file has corrupt bytes: the reason, and the number of bytes from there on, which are not used.
    Damaged(String, u64),
}

impl End {
    /// Returns the reason for an early end and the number of unused bytes; `None` for a complete file.
    pub fn early(&self) -> Option<(&str, u64)> {
        match self {
            End::Whole => None,
            End::Cut(why, bytes) | End::Damaged(why, bytes) => Some((why, *bytes)),
        }
    }
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            End::Whole => f.write_str("the file is complete"),
            End::Cut(why, bytes) => write!(f, "the file was cut off: {why}; the last {bytes} bytes are not used"),
            End::Damaged(why, bytes) => {
                write!(f, "the file is damaged: {why}; the last {bytes} bytes are not used")
            }
        }
    }
}

/// Streaming reader of a file.
pub struct Source {
    path: PathBuf,
    file: BufReader<File>,
    size: u64,
    /// Bytes passed to the reader, and those up to the last complete item.
    read: u64,
    used: u64,
    /// Longest record that is read \[bytes\].
    most: u64,
    record: Vec<u8>,
    reader: LinearReader,
    known: ChannelAccumulator<'static>,
    end: Option<End>,
    /// True if the file ends with the closing magic bytes.
    finished: bool,
}

impl Source {
    /// Opens the file at `path`.
    pub fn open(path: &Path) -> Result<Source, FileError> {
        let io = |e: &std::io::Error| FileError::io(path, "it cannot be read", e);
        let file = File::open(path).map_err(|e| io(&e))?;
        let about = file.metadata().map_err(|e| io(&e))?;
        if !about.is_file() {
            // `/dev/zero` never ends
            let e = FileError::format("not a regular file").file(path.display());
            return Err(e.fix("give a take that `ca` recorded"));
        }
        let size = about.len();
        let mut tail = Vec::new();
        let seek = |to| (&file).seek(to).map_err(|e| io(&e));
        seek(SeekFrom::Start(size.saturating_sub(mcap::MAGIC.len() as u64)))?;
        (&file).read_to_end(&mut tail).map_err(|e| io(&e))?;
        seek(SeekFrom::Start(0))?;
        let mut file = BufReader::with_capacity(1 << 16, file);
        let mut magic = Vec::new();
        file.by_ref().take(mcap::MAGIC.len() as u64).read_to_end(&mut magic).map_err(|e| io(&e))?;
        if magic != mcap::MAGIC {
            let e = FileError::format("it is not an MCAP file").file(path.display());
            return Err(e.fix("give a take that `ca` recorded"));
        }
        let most = CHUNK.saturating_add(size as usize);
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(most);
        let mut reader = LinearReader::new_with_options(options);
        // the first bytes too, because the checksum over all bytes includes them
        feed(&mut reader, &magic);
        Ok(Source {
            path: path.to_owned(),
            file,
            size,
            read: magic.len() as u64,
            used: 0,
            most: most as u64,
            record: Vec::new(),
            reader,
            known: ChannelAccumulator::default(),
            end: None,
            finished: tail == mcap::MAGIC,
        })
    }

    /// Returns how the file ended; `None` before its end.
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    fn cut(&mut self, e: &McapError) -> Option<Result<Item, FileError>> {
        let left = self.size.saturating_sub(self.used);
        self.end = Some(match e {
            // a file with its last bytes in place was not cut
            McapError::UnexpectedEof if !self.finished => End::Cut("it ends in the middle".into(), left),
            McapError::UnexpectedEof => End::Damaged("a record is longer than the file".into(), left),
            e => End::Damaged(ca_io::error::lower(&e.to_string()), left),
        });
        None
    }

    fn accept(&mut self, record: Record<'static>) -> Result<Option<Item>, McapError> {
        Ok(match record {
            Record::Schema { header, data } => {
                self.known.add_schema(header, data)?;
                None
            }
            Record::Channel(c) => {
                self.known.add_channel(c)?;
                None
            }
            Record::Message { header, data } => {
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                let channel = self.known.get(header.channel_id).ok_or(unknown)?;
                let (sequence, time) = (header.sequence, header.log_time);
                Some(Item::Message { channel, sequence, time, data: data.into_owned() })
            }
            Record::Attachment { header, data, .. } => Some(Item::Attachment {
                name: header.name,
                media: header.media_type,
                time: header.log_time,
                data: data.into_owned(),
            }),
            Record::Metadata(m) => Some(Item::Metadata(m)),
            Record::DataEnd(_) => {
                let index = || End::Cut("only its index is missing".into(), 0);
                self.end = Some(if self.finished { End::Whole } else { index() });
                None
            }
            // kinds from 0x80 on are free for private use
            Record::Unknown { opcode, .. } if opcode < 0x80 => {
                let why = format!("it has a record of unknown kind {opcode:#04x}");
                self.end = Some(End::Damaged(why, self.size.saturating_sub(self.used)));
                None
            }
            _ => None,
        })
    }
}

impl Iterator for Source {
    type Item = Result<Item, FileError>;

    fn next(&mut self) -> Option<Self::Item> {
        while self.end.is_none() {
            let record = match self.reader.next_event() {
                None => return self.cut(&McapError::UnexpectedEof),
                Some(Err(e)) => return self.cut(&e),
                Some(Ok(LinearReadEvent::ReadRequest(_))) => {
                    if let Err(e) = mcap_records::next(&mut self.file, self.most, &mut self.record) {
                        self.end = Some(End::Whole);
                        return Some(Err(FileError::io(&self.path, "it cannot be read", &e)));
                    }
                    let whole = mcap_records::record(&self.record);
                    if let Some(Err(e)) = whole.map(|(kind, body)| mcap_records::check(kind, body)) {
                        return self.cut(&e);
                    }
                    feed(&mut self.reader, &self.record);
                    self.read += self.record.len() as u64;
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    // records in a chunk are not checked yet
                    mcap_records::check(opcode, data)
                        .and_then(|()| mcap::parse_record(opcode, data))
                        .map(Record::into_owned)
                }
            };
            self.used = self.read;
            match record.and_then(|r| self.accept(r)) {
                Ok(Some(item)) => return Some(Ok(item)),
                Ok(None) => {}
                Err(e) => return self.cut(&e),
            }
        }
        None
    }
}

/// Passes bytes to the reader; none at the end of the file.
fn feed(reader: &mut LinearReader, bytes: &[u8]) {
    if let Some(to) = reader.insert(bytes.len()).get_mut(..bytes.len()) {
        to.copy_from_slice(bytes);
    }
    reader.notify_read(bytes.len());
}

/// Returns the error for a message that does not match its topic.
pub fn torn(topic: &str, sequence: u32) -> FileError {
    FileError::new(FileErrorKind::Format, format!("message {sequence} of topic `{topic}` does not match its schema"))
}
