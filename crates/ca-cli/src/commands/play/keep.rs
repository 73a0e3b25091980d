//! Keeps a performance from its page: the sound from now on as WAV, and all that was done so far as a take.
//!
//! All that is done is written down, without sound, so that a player can still keep what has just been played well. The
//! name of the file is removed at once, so that the system removes the file with the process, however that ends. A model
//! with devices would fill the disk and keeps it only by `--log`. Files are written where the program was started, under a name that is free, on threads
//! for them alone.

use crate::commands::serve::Wav;
use crate::term;
use ca_core::Scene;
use ca_haptic::record::Record;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::{AsyncSink, BufferLimits, Recorder, Sink, SinkHandle, SinkStreams};
use ca_haptic::take::{Header, Recovered, TakeWriter, recover};
use ca_haptic::version::Version;
use ca_io::FileError;
use ca_io::sound::{Format, WavOut, Written};
use ca_session::Files;
use std::fs::File;
use std::os::fd::AsRawFd as _;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Names that are tried.
const TRIES: u32 = 10_000;

/// A take under way in the folder for temporary files, from which takes are saved.
pub(crate) struct Kept {
    /// the file where it can be read
    path: PathBuf,
    /// its name is removed already; `path` is this handle
    unnamed: Option<File>,
    saving: Saving,
    sink: Option<AsyncSink<KeptSink>>,
}

/// The take that is to be saved with the next mark of the engine.
type Saving = Arc<Mutex<Option<Save>>>;

struct Save {
    to: PathBuf,
    tell: Sender<Result<String, String>>,
}

/// Writes the take, and saves a copy of it at a mark: every record from before the mark is written by then.
pub(crate) struct KeptSink {
    writer: TakeWriter,
    path: PathBuf,
    saving: Saving,
}

impl KeptSink {
    fn save(&mut self) {
        let Some(Save { to, tell }) = self.saving.lock().unwrap_or_else(PoisonError::into_inner).take() else { return };
        let saved = self.writer.flush().and_then(|()| recover(&self.path, &to));
        let said = |s: Recovered| format!("saved {:.1} s as {}; `ca replay` plays it again", s.seconds, to.display());
        let _ = tell.send(saved.map(said).map_err(|e| e.to_string()));
    }
}

impl Sink for KeptSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { records: true, ..SinkStreams::WORDS }
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

impl Kept {
    /// Begins, and gives the recorder's end.
    ///
    /// # Errors
    /// Where nothing can be written for the time being.
    pub(crate) fn begin(header: &Header, scene: &Scene) -> Result<(Kept, SinkHandle), FileError> {
        let path = std::env::temp_dir().join(format!("ca-{:016x}.mcap", header.engine.session));
        let writer = TakeWriter::create(&path, header, scene)?;
        let unnamed = unnamed(&path);
        let path = unnamed.as_ref().map_or(path, by_handle);
        let saving = Saving::default();
        let sink = KeptSink { writer, path: path.clone(), saving: saving.clone() };
        let (line, sink) = AsyncSink::start("ca kept", sink, BufferLimits::of(scene), RtRequest::default())?;
        Ok((Kept { path, unnamed, saving, sink: Some(sink) }, line))
    }
}

impl Drop for Kept {
    /// A take whose mark the engine did not come to is saved with what there is.
    fn drop(&mut self) {
        if let Some(Ok(Some(mut sink))) = self.sink.take().map(AsyncSink::end) {
            sink.save();
        }
        if self.unnamed.is_none() {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Removes the name of a file that is open; `None` where it could not be read any more without its name.
fn unnamed(path: &Path) -> Option<File> {
    let file = File::open(path).ok()?;
    by_handle(&file).exists().then_some(())?;
    std::fs::remove_file(path).ok()?;
    Some(file)
}

/// The path at which Linux has an open file of this process.
fn by_handle(file: &File) -> PathBuf {
    PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
}

/// Sound that is being written.
struct Tape {
    path: PathBuf,
    sink: AsyncSink<Wav>,
}

/// The recorder's end of the sound, where some is written, and why it was ended where nobody did.
#[derive(Default)]
struct TapeEnd {
    line: Option<SinkHandle>,
    failed: Option<FileError>,
}

/// Both, for the recorder and for who records.
#[derive(Clone, Default)]
pub(crate) struct TapeSink(Arc<Mutex<TapeEnd>>);

impl TapeSink {
    fn end(&self) -> MutexGuard<'_, TapeEnd> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, line: Option<SinkHandle>) {
        *self.end() = TapeEnd { line, failed: None };
    }
}

impl Sink for TapeSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::WORDS }
    }

    fn news(&mut self) -> Option<(bool, String)> {
        self.end().line.as_mut().and_then(Sink::news)
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        let mut end = self.end();
        if let Some(Err(e)) = end.line.as_mut().map(|l| l.sound(tick, frames)) {
            *end = TapeEnd { line: None, failed: Some(e) };
        }
        Ok(())
    }
}

/// What a page can keep.
pub(crate) struct Keep {
    /// name of the model without its folder and endings
    stem: String,
    kept: Option<Kept>,
    tape: Option<Tape>,
    line: TapeSink,
    /// files that are being finished
    ends: Vec<Receiver<Result<String, String>>>,
    /// that of a take
    saves: Option<Receiver<Result<String, String>>>,
}

impl Keep {
    /// For a model of this name; what was done so far in `kept`.
    pub(crate) fn new(model: &str, kept: Option<Kept>, line: TapeSink) -> Keep {
        let file = model.rsplit(['/', '\\']).next().unwrap_or(model);
        let stem = file.split('.').next().filter(|s| !s.is_empty()).unwrap_or("take").to_string();
        Keep { stem, kept, tape: None, line, ends: Vec::new(), saves: None }
    }

    /// Ends what is recorded, if it is.
    fn stop(&mut self) -> Option<String> {
        let Tape { path, sink } = self.tape.take()?;
        self.line.set(None);
        let text = format!("{} is finished", path.display());
        let end = aside(move || {
            let written = sink.end().and_then(|w| w.map(Wav::finish).transpose());
            let told = |w: Option<Written>| match w {
                Some(w) => format!("recorded {:.1} s into {}", w.frames as f64 / f64::from(w.rate), path.display()),
                None => format!("{} could not be written to its end", path.display()),
            };
            written.map(told).map_err(|e| e.to_string())
        });
        self.ends.push(end);
        Some(text)
    }

    /// A file that is not there yet.
    fn free(&self, ending: &str) -> Result<PathBuf, String> {
        let path = |n: u32| PathBuf::from(format!("{}-{n}.{ending}", self.stem));
        let free = (1..TRIES).map(path).find(|p| !p.exists());
        free.ok_or_else(|| format!("there are {TRIES} files {}-… here already", self.stem))
    }
}

impl Files for Keep {
    fn can_save(&self) -> bool {
        self.kept.is_some()
    }

    fn recording(&self) -> Option<String> {
        self.tape.as_ref().map(|t| t.path.display().to_string())
    }

    fn turn(&mut self, recorder: &mut Recorder) {
        let failed = self.line.end().failed.take();
        if let Some((e, tape)) = failed.and_then(|e| Some((e, self.tape.take()?))) {
            recorder.say(true, format!("{} is not recorded any more: {e}", tape.path.display()));
        }
        let mut waits = |end: &Receiver<Result<String, String>>| match end.try_recv() {
            Ok(came) => {
                recorder.say(came.is_err(), came.unwrap_or_else(|why| why));
                false
            }
            Err(e) => e == TryRecvError::Empty,
        };
        self.ends.retain(&mut waits);
        self.saves = self.saves.take().filter(waits);
    }

    fn record(&mut self, on: bool, scene: &Scene) -> Result<String, ca_session::Refused> {
        if !on {
            return self.stop().ok_or_else(|| "nothing is recorded".into());
        }
        if self.tape.is_some() {
            return Err("it is recorded already".into());
        }
        if scene.counts.channels == 0 {
            return Err("the model has no output, so there is no sound to record".into());
        }
        let path = self.free("wav")?;
        let out = WavOut::create(&path, scene.rate, scene.counts.channels, Format::F32).map_err(|e| e.to_string())?;
        let wav = Wav::from_now(out, scene.counts.channels);
        let started = AsyncSink::start("ca record", wav, BufferLimits::of(scene), RtRequest::default());
        let (line, sink) = started.map_err(|e| e.to_string())?;
        self.line.set(Some(line));
        let text = format!("records into {}", path.display());
        self.tape = Some(Tape { path, sink });
        Ok(text)
    }

    fn save(&mut self, recorder: &mut Recorder) -> Result<String, ca_session::Refused> {
        let Some(kept) = &self.kept else {
            return Err("what devices did is kept only with --log TAKE, from the start".into());
        };
        if self.saves.is_some() {
            return Err("a take is being saved; once that is done, save another".into());
        }
        let to = self.free("mcap")?;
        let text = format!("saves {}", to.display());
        let (tell, end) = channel();
        let saving = |save| *kept.saving.lock().unwrap_or_else(PoisonError::into_inner) = save;
        saving(Some(Save { to, tell }));
        recorder.mark().inspect_err(|_| saving(None))?;
        self.saves = Some(end);
        Ok(text)
    }
}

/// Does what may wait for a disk on a thread of its own; what came of it.
fn aside(work: impl FnOnce() -> Result<String, String> + Send + 'static) -> Receiver<Result<String, String>> {
    let (tell, end) = channel();
    let run = move || {
        let _ = tell.send(work());
    };
    if let Err(e) = thread::Builder::new().name("ca keep".into()).spawn(run) {
        term::warning(&format!("no thread to write with: {e}"));
    }
    end
}

impl Drop for Keep {
    /// What is recorded is finished before the program is.
    fn drop(&mut self) {
        self.stop();
        self.kept = None;
        for end in self.ends.drain(..).chain(self.saves.take()) {
            let _ = end.recv();
        }
    }
}
