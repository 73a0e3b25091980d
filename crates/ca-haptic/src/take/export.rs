//! Exports a part of a take to a file for other programs.
//!
//! Topics with a ROS 2 definition are exported by it: to NPY as a structured array, whose rows are the bytes of the
//! messages, and to CSV with a column per number, arrays cut to the degrees of freedom of the device. Messages for
//! viewers are not exported. Sound becomes a WAV file of 32-bit floats.

use super::cdr::{self, Field, In, Kind};
use super::read::{Event, Take};
use super::source::{Item, Source, torn};
use crate::frame::DOF;
use ca_io::atomic_file::AtomicFile;
use ca_io::error::FileError;
use ca_io::format::Format;
use ca_io::sound::{WavOut, Written};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

/// Length of an NPY header \[bytes\], a multiple of 64: enough for the fields of a frame and any number of rows.
const HEADER: usize = 1024;

/// Writes the sound of a take to a WAV file of 32-bit floats; missing stretches are silent.
///
/// # Errors
/// If the take holds no sound, or the file cannot be written.
pub fn sound(take: &Take, to: impl AsRef<Path>) -> Result<Written, FileError> {
    let channels = take.header.channels.len();
    let mut out = WavOut::create(to, take.header.rate, channels, Format::F32)?;
    for event in take.events()? {
        if let Event::Sound(tick, samples) = event? {
            let gap = tick.saturating_sub(out.so_far().frames) as usize;
            out.write(&vec![0.0; gap * channels])?;
            out.write(&samples)?;
        }
    }
    out.finish()
}

/// Writes the named attachment of a take to a file and returns its size.
///
/// # Errors
/// If the attachment does not exist, or the file cannot be written.
pub fn attachment(take: &Take, name: &str, to: impl AsRef<Path>) -> Result<u64, FileError> {
    let to = to.as_ref();
    for item in Source::open(&take.path)? {
        match item? {
            Item::Attachment { name: own, data, .. } if own == name => {
                let staged = AtomicFile::create(to)?;
                let done = staged.handle()?.write_all(&data);
                done.map_err(|e| FileError::io(to, "it cannot be written", &e))?;
                staged.commit()?;
                return Ok(data.len() as u64);
            }
            _ => {}
        }
    }
    let e = FileError::usage(format!("no attachment `{name}`")).file(take.path.display());
    Err(e.fix("`ca log info` lists the attachments"))
}

/// Writes a topic to a `.csv` or `.npy` file and returns the number of messages.
///
/// # Errors
/// If the topic does not exist or is for viewers, a message does not match its schema, or the file cannot be written.
pub fn messages(take: &Take, topic: &str, to: impl AsRef<Path>) -> Result<u64, FileError> {
    let to = to.as_ref();
    let ext = to.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let array = match ext.as_deref() {
        Some("npy") => true,
        Some("csv") => false,
        _ => {
            let e = FileError::unsupported("a topic can only be exported as `.csv` or `.npy`").file(to.display());
            return Err(e.fix("use one of these extensions; only `sound` can be a `.wav`"));
        }
    };
    let mut table: Option<ChannelTable> = None;
    for item in Source::open(&take.path)? {
        let Item::Message { channel, sequence, time, data } = item? else { continue };
        if channel.topic != topic {
            continue;
        }
        let table = match &mut table {
            Some(table) => table,
            none => {
                let schema = channel.schema.as_ref().filter(|s| s.encoding == "ros2msg");
                let Some(schema) = schema else {
                    let e = FileError::unsupported(format!("topic `{topic}` is for viewers and cannot be exported"));
                    return Err(e.file(take.path.display()).fix("read it with `mcap-protobuf-support` in Python"));
                };
                let fields = cdr::fields(&String::from_utf8_lossy(&schema.data));
                none.insert(ChannelTable::begin(to, fields, array, shown(take, topic))?)
            }
        };
        let seconds = time.saturating_sub(take.header.began_ns) as f64 * 1e-9;
        table.row(seconds, &data).ok_or_else(|| torn(topic, sequence).file(take.path.display()))??;
    }
    let Some(table) = table else {
        let e = FileError::usage(format!("no messages on topic `{topic}`")).file(take.path.display());
        return Err(e.fix("`ca log info` lists the topics"));
    };
    table.finish()
}

/// Returns how many elements of long arrays are shown: the degrees of freedom of the device.
fn shown(take: &Take, topic: &str) -> usize {
    let of = |s: &&crate::engine::Setup| topic.split('/').nth(2) == Some(&s.device);
    take.header.setups.iter().find(of).map_or(DOF, |s| s.profile.dof as usize)
}

struct ChannelTable<'a> {
    to: &'a Path,
    out: BufWriter<File>,
    staged: AtomicFile,
    fields: Vec<Field>,
    array: bool,
    shown: usize,
    rows: u64,
}

impl<'a> ChannelTable<'a> {
    fn begin(to: &'a Path, fields: Vec<Field>, array: bool, shown: usize) -> Result<ChannelTable<'a>, FileError> {
        if array && !fields.iter().all(Field::is_fixed) {
            let e = FileError::unsupported("the messages differ in length, so they do not fit into an array")
                .file(to.display());
            return Err(e.fix("use `.csv`"));
        }
        let staged = AtomicFile::create(to)?;
        let out = BufWriter::new(staged.handle()?);
        let mut t = ChannelTable { to, out, staged, fields, array, shown, rows: 0 };
        let head = if array { t.header() } else { t.names().into_bytes() };
        t.write(&head)?;
        Ok(t)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), FileError> {
        self.out.write_all(bytes).map_err(|e| FileError::io(self.to, "it cannot be written", &e))
    }

    /// Returns the columns of a field; a list has a single one for all its elements.
    fn columns(&self, f: &Field) -> usize {
        match f.count {
            Some(DOF) => self.shown,
            Some(n) if f.kind != Kind::Uint(1) => n,
            _ => 1,
        }
    }

    fn names(&self) -> String {
        let mut line = String::from("time");
        for f in &self.fields {
            let n = self.columns(f);
            for k in 0..n {
                let _ = if n > 1 || f.count == Some(DOF) {
                    write!(line, ",{}[{k}]", f.name)
                } else {
                    write!(line, ",{}", f.name)
                };
            }
        }
        line.push('\n');
        line
    }

    /// Writes a row; `None` where the message does not match its topic.
    fn row(&mut self, time: f64, data: &[u8]) -> Option<Result<(), FileError>> {
        self.rows += 1;
        if self.array {
            let body = data.strip_prefix(&cdr::HEAD)?;
            let size: usize = self.fields.iter().map(Field::size).sum();
            return (body.len() == size).then(|| self.write(body));
        }
        let mut r = In::new(data)?;
        let mut line = time.to_string();
        for f in &self.fields {
            let values = cdr::show(f, &mut r).ok()?;
            match (f.kind, f.count) {
                // names of devices
                (Kind::Uint(1), Some(n)) if n > 1 => {
                    let bytes: Vec<u8> = values.iter().filter_map(|v| v.parse().ok()).collect();
                    let _ = write!(line, ",{}", quoted(&crate::frame::text(&bytes)));
                }
                (Kind::Text, _) => {
                    let _ = write!(line, ",{}", quoted(&values.concat()));
                }
                (_, None) => {
                    let _ = write!(line, ",{}", values.join(" "));
                }
                _ => values.iter().take(self.columns(f)).for_each(|v| {
                    let _ = write!(line, ",{v}");
                }),
            }
        }
        line.push('\n');
        Some(self.write(line.as_bytes()))
    }

    fn finish(mut self) -> Result<u64, FileError> {
        let head = self.header();
        let mut done = self.out.flush();
        if self.array {
            done = done.and_then(|()| self.out.seek(SeekFrom::Start(0)).map(|_| ()));
            done = done.and_then(|()| self.out.write_all(&head)).and_then(|()| self.out.flush());
        }
        done.map_err(|e| FileError::io(self.to, "it cannot be written", &e))?;
        self.staged.commit()?;
        Ok(self.rows)
    }

    /// Returns an NPY header of version 1.0 for a structured array, always of the same length.
    fn header(&self) -> Vec<u8> {
        let field = |f: &Field| {
            let ty = match f.kind {
                Kind::Float(n) => format!("<f{n}"),
                Kind::Uint(1) => "|u1".into(),
                Kind::Uint(n) => format!("<u{n}"),
                Kind::Text => String::new(),
            };
            match f.count {
                Some(n) if n > 1 => format!("('{}', '{ty}', ({n},)), ", f.name),
                _ => format!("('{}', '{ty}'), ", f.name),
            }
        };
        let fields: String = self.fields.iter().map(field).collect();
        let rows = self.rows;
        let dict = format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}", fields.trim_end());
        let mut b = b"\x93NUMPY\x01\x00".to_vec();
        b.extend(((HEADER - 10) as u16).to_le_bytes());
        b.extend(format!("{dict:<width$}\n", width = HEADER - 11).as_bytes());
        b
    }
}

/// Quotes a text as a CSV cell.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r', '#']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}
