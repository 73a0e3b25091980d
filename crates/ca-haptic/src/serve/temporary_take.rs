//! A take of everything played so far, from which copies can be saved.
//!
//! It is written without sound to a temporary file. The name of the file is removed at once, so that the system deletes
//! the file when the process ends. A separate thread writes the take and its copies.

use super::Refused;
use super::sink::{Sink, SinkStreams};
use super::{AsyncSink, BufferLimits, Recorder, SinkHandle};
use crate::record::Record;
use crate::rt::RtRequest;
use crate::take::{Header, Recovered, TakeWriter, recover};
use crate::version::Version;
use ca_core::Scene;
use ca_io::FileError;
use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};

/// A take in progress in the folder for temporary files, from which copies can be saved.
pub struct TemporaryTake {
    /// Path from which the file can be read.
    path: PathBuf,
    /// Open file without a name, to which `path` refers; `None` if the name remains.
    unnamed: Option<File>,
    saving: Saving,
    sink: Option<AsyncSink<TemporaryTakeSink>>,
}

/// Copy to be saved at the next mark of the engine.
type Saving = Arc<Mutex<Option<Save>>>;

struct Save {
    to: PathBuf,
    tell: Sender<Result<String, FileError>>,
}

/// Writes the take, and saves a copy at a mark, when each record before the mark has been written.
struct TemporaryTakeSink {
    writer: TakeWriter,
    path: PathBuf,
    saving: Saving,
}

impl TemporaryTakeSink {
    fn save(&mut self) {
        let Some(Save { to, tell }) = self.saving.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        let saved = self.writer.flush().and_then(|()| recover(&self.path, &to));
        let said =
            |s: Recovered| format!("saved {:.1} s as {1}; play it with `ca replay {1}`", s.seconds, to.display());
        let _ = tell.send(saved.map(said));
    }
}

impl Sink for TemporaryTakeSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { records: true, ..SinkStreams::MESSAGES }
    }

    fn record(&mut self, record: &Record) -> Result<(), FileError> {
        self.writer.record(record)?;
        if matches!(record, Record::Marked { .. }) {
            self.save();
        }
        Ok(())
    }

    fn swapped(&mut self, tick: u64, version: &Arc<Version>) -> Result<(), FileError> {
        self.writer.swapped(tick, version)
    }
}

impl TemporaryTake {
    /// Begins a take, and returns it with the sink for the recorder.
    ///
    /// # Errors
    /// If nothing can be written to the folder for temporary files.
    pub fn begin(header: &Header, scene: &Scene) -> Result<(TemporaryTake, SinkHandle), FileError> {
        let path = std::env::temp_dir().join(format!("ca-{:016x}.mcap", header.engine.session));
        let writer = TakeWriter::create(&path, header, scene)?;
        let unnamed = unnamed(&path);
        let path = unnamed.as_ref().map_or(path, by_handle);
        let saving = Saving::default();
        let sink = TemporaryTakeSink { writer, path: path.clone(), saving: saving.clone() };
        let (line, sink) = AsyncSink::start("ca kept", sink, BufferLimits::of(scene), RtRequest::default())?;
        Ok((TemporaryTake { path, unnamed, saving, sink: Some(sink) }, line))
    }

    /// Saves a copy of everything played so far to `to`. The receiver gets the result with a message once it is done.
    ///
    /// # Errors
    /// If the engine does not take commands now.
    pub fn save(&self, to: PathBuf, recorder: &mut Recorder) -> Result<Receiver<Result<String, FileError>>, Refused> {
        let (tell, end) = channel();
        let saving = |save| *self.saving.lock().unwrap_or_else(PoisonError::into_inner) = save;
        saving(Some(Save { to, tell }));
        recorder.mark().inspect_err(|_| saving(None))?;
        Ok(end)
    }
}

impl Drop for TemporaryTake {
    /// Saves a copy whose mark the engine did not reach, with the records so far.
    fn drop(&mut self) {
        if let Some(Ok(Some(mut sink))) = self.sink.take().map(AsyncSink::end) {
            sink.save();
        }
        if self.unnamed.is_none() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Opens a file and removes its name; `None` if it could not be read without the name.
fn unnamed(path: &Path) -> Option<File> {
    let file = File::open(path).ok()?;
    by_handle(&file).exists().then_some(())?;
    std::fs::remove_file(path).ok()?;
    Some(file)
}

/// Returns the path that Linux gives an open file of this process.
fn by_handle(file: &File) -> PathBuf {
    PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
}
