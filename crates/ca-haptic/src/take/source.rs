//! An MCAP file from its beginning to wherever it ends.
//!
//! Decides to read in a stream, so that a take of an hour takes no more memory than one of a second, and to check each
//! chunk as a whole before anything of it is used: a file that ends early gives all that was written whole, and then
//! says that it was cut. One in which bytes are not as they were written gives what came before them and says that it is
//! damaged, which is more than cut: what follows was played, and is not there. The sum over all bytes at the end of a
//! finished file finds what no chunk does.

use super::framed;
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

/// Room for a chunk that shrank well \[bytes\].
const CHUNK: usize = 64 << 20;

/// One thing in the file.
pub enum Item {
    /// a message
    Message {
        /// its channel
        channel: Arc<mcap::Channel<'static>>,
        /// its number
        sequence: u32,
        /// since 1970 \[ns\]
        time: u64,
        /// its bytes
        data: Vec<u8>,
    },
    /// a file within the file
    Attachment {
        /// its name
        name: String,
        /// what it is
        media: String,
        /// since 1970 \[ns\]
        time: u64,
        /// its bytes
        data: Vec<u8>,
    },
    /// names and texts
    Metadata(Metadata),
}

/// How a file ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// as its writer meant
    Whole,
    /// early, as of a writer that was killed: why, and how many bytes at the end are of no use
    Cut(String, u64),
    /// in the middle, at bytes that are not as they were written: why, and how many bytes from there on are not used
    Damaged(String, u64),
}

impl End {
    /// Why it ended before its end, and how many bytes are not used; `None` where it is whole.
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
            End::Whole => f.write_str("the file is whole"),
            End::Cut(why, bytes) => write!(f, "the file was cut off: {why}; {bytes} bytes at its end are of no use"),
            End::Damaged(why, bytes) => {
                write!(f, "the file is damaged: {why}; {bytes} bytes from there on are not used")
            }
        }
    }
}

/// Reads a file.
pub struct Source {
    path: PathBuf,
    file: BufReader<File>,
    size: u64,
    /// bytes handed to the reader, and those up to the last thing that was whole
    read: u64,
    used: u64,
    /// the longest record that is read \[bytes\]
    most: u64,
    /// the record that is handed to the reader
    record: Vec<u8>,
    reader: LinearReader,
    known: ChannelAccumulator<'static>,
    end: Option<End>,
    /// whether its last bytes are those of a finished file
    finished: bool,
}

impl Source {
    /// At the beginning of the file at `path`.
    pub fn open(path: &Path) -> Result<Source, FileError> {
        let io = |e: &std::io::Error| FileError::io(path, "it cannot be read", e);
        let file = File::open(path).map_err(|e| io(&e))?;
        let about = file.metadata().map_err(|e| io(&e))?;
        if !about.is_file() {
            // `/dev/zero` never ends
            let e = FileError::format("not a regular file").file(path.display());
            return Err(e.fix("give a file that `ca` wrote while playing"));
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
            let e = FileError::format("it is no MCAP file").file(path.display());
            return Err(e.fix("give a file that `ca` wrote while playing"));
        }
        let most = CHUNK.saturating_add(size as usize);
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(most);
        let mut reader = LinearReader::new_with_options(options);
        // from its first byte, which the sum over all bytes counts
        hand(&mut reader, &magic);
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

    /// How it ended; `None` while it has not.
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
            // kinds from 0x80 on are anybody's
            Record::Unknown { opcode, .. } if opcode < 0x80 => {
                let why = format!("a record of kind {opcode:#04x}, which no take has");
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
                    if let Err(e) = framed::next(&mut self.file, self.most, &mut self.record) {
                        self.end = Some(End::Whole);
                        return Some(Err(FileError::io(&self.path, "it cannot be read", &e)));
                    }
                    let whole = framed::record(&self.record);
                    if let Some(Err(e)) = whole.map(|(kind, body)| framed::check(kind, body)) {
                        return self.cut(&e);
                    }
                    hand(&mut self.reader, &self.record);
                    self.read += self.record.len() as u64;
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    // a record in a chunk has not been looked at
                    framed::check(opcode, data).and_then(|()| mcap::parse_record(opcode, data)).map(Record::into_owned)
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

/// Hands bytes to the reader; none at the end of the file.
fn hand(reader: &mut LinearReader, bytes: &[u8]) {
    if let Some(to) = reader.insert(bytes.len()).get_mut(..bytes.len()) {
        to.copy_from_slice(bytes);
    }
    reader.notify_read(bytes.len());
}

/// What is wrong with a message.
pub fn torn(topic: &str, sequence: u32) -> FileError {
    FileError::new(FileErrorKind::Format, format!("message {sequence} of `{topic}` is not what its topic holds"))
}
