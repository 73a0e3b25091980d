//! Saves a performance from its page: the sound from now on as WAV, or everything so far as a take ([`TemporaryTake`]).
//!
//! Separate threads write the files, under a free name in the directory where the program was started. A model with
//! devices would fill the disk, so its take can only be recorded from the start with `--log`.

use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::{AsyncSink, BufferLimits, Recorder, Sink, SinkHandle, SinkStreams, TemporaryTake, WavSink};
use ca_io::FileError;
use ca_io::format::Format;
use ca_io::sound::{WavOut, Written};
use ca_session::Files;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Limit on the file names tried.
const TRIES: u32 = 10_000;

struct SoundFile {
    path: PathBuf,
    sink: AsyncSink<WavSink>,
}

/// The recorder's connection to the sound file, and the error if writing failed.
#[derive(Default)]
struct SoundFileState {
    sink: Option<SinkHandle>,
    failed: Option<FileError>,
}

/// Connection to the sound file, shared by the recorder and [`PageFiles`].
#[derive(Clone, Default)]
pub struct SoundFileSink(Arc<Mutex<SoundFileState>>);

impl SoundFileSink {
    fn state(&self) -> MutexGuard<'_, SoundFileState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, sink: Option<SinkHandle>) {
        *self.state() = SoundFileState { sink, failed: None };
    }
}

impl Sink for SoundFileSink {
    fn streams(&self) -> SinkStreams {
        SinkStreams { sound: true, ..SinkStreams::MESSAGES }
    }

    fn poll_notice(&mut self) -> Option<(bool, String)> {
        self.state().sink.as_mut().and_then(Sink::poll_notice)
    }

    fn sound(&mut self, tick: u64, frames: &[f64]) -> Result<(), FileError> {
        let mut end = self.state();
        if let Some(Err(e)) = end.sink.as_mut().map(|l| l.sound(tick, frames)) {
            *end = SoundFileState { sink: None, failed: Some(e) };
        }
        Ok(())
    }
}

/// Files saved from a page.
pub struct PageFiles {
    /// Name of the model without folder and extensions.
    stem: String,
    take: Option<TemporaryTake>,
    sound_file: Option<SoundFile>,
    sink: SoundFileSink,
    /// Results of sound files that are being finished.
    finishing: Vec<Receiver<Result<String, FileError>>>,
    /// Result of the take that is being saved.
    saving: Option<Receiver<Result<String, FileError>>>,
}

impl PageFiles {
    /// Prepares the files for a model. `take` holds the performance so far.
    pub fn new(model: &str, take: Option<TemporaryTake>, sink: SoundFileSink) -> PageFiles {
        let file = model.rsplit(['/', '\\']).next().unwrap_or(model);
        let stem = file.split('.').next().filter(|s| !s.is_empty()).unwrap_or("take").to_string();
        PageFiles { stem, take, sound_file: None, sink, finishing: Vec::new(), saving: None }
    }

    fn stop(&mut self) -> Option<String> {
        let SoundFile { path, sink } = self.sound_file.take()?;
        self.sink.set(None);
        let text = format!("finishing {}", path.display());
        let end = spawn_writer(move || {
            let written = sink.end().and_then(|w| w.map(WavSink::finish).transpose());
            let told = |w: Option<Written>| match w {
                Some(w) => format!("recorded {:.1} s into {}", w.frames as f64 / f64::from(w.rate), path.display()),
                None => format!("{} could not be completed", path.display()),
            };
            written.map(told)
        });
        self.finishing.push(end);
        Some(text)
    }

    /// Returns a path that does not exist yet.
    fn free(&self, ending: &str) -> Result<PathBuf, ca_session::Refused> {
        let path = |n: u32| PathBuf::from(format!("{}-{n}.{ending}", self.stem));
        let free = (1..=TRIES).map(path).find(|p| !p.exists());
        free.ok_or_else(|| {
            format!("this folder already has {TRIES} files {}-….{ending}; move some of them away", self.stem).into()
        })
    }
}

impl Files for PageFiles {
    fn can_save(&self) -> bool {
        self.take.is_some()
    }

    fn recording(&self) -> Option<String> {
        self.sound_file.as_ref().map(|t| t.path.display().to_string())
    }

    fn poll(&mut self, recorder: &mut Recorder) {
        let failed = self.sink.state().failed.take();
        if let Some((e, sound_file)) = failed.and_then(|e| Some((e, self.sound_file.take()?))) {
            recorder.say(true, format!("recording into {} stopped: {e}", sound_file.path.display()));
        }
        let mut waits = |end: &Receiver<Result<String, FileError>>| match end.try_recv() {
            Ok(came) => {
                recorder.say(came.is_err(), came.unwrap_or_else(|why| why.to_string()));
                false
            }
            Err(e) => e == TryRecvError::Empty,
        };
        self.finishing.retain(&mut waits);
        self.saving = self.saving.take().filter(waits);
    }

    fn record(&mut self, on: bool, scene: &Scene) -> Result<String, ca_session::Refused> {
        if !on {
            return self.stop().ok_or_else(|| "the sound is not being recorded".into());
        }
        if self.sound_file.is_some() {
            return Err("the sound is already being recorded".into());
        }
        if scene.counts.channels == 0 {
            return Err("the model has no output, so there is no sound to record".into());
        }
        let path = self.free("wav")?;
        let out = WavOut::create(&path, scene.rate, scene.counts.channels, Format::F32).map_err(|e| e.to_string())?;
        let wav = WavSink::from_now(out, scene.counts.channels);
        let started = AsyncSink::start("ca record", wav, BufferLimits::of(scene), RtRequest::default());
        let (handle, sink) = started.map_err(|e| e.to_string())?;
        self.sink.set(Some(handle));
        let text = format!("recording into {}", path.display());
        self.sound_file = Some(SoundFile { path, sink });
        Ok(text)
    }

    fn save(&mut self, recorder: &mut Recorder) -> Result<String, ca_session::Refused> {
        let Some(take) = &self.take else {
            return Err("a take of a model with devices can be recorded only from the start, with `--log TAKE`".into());
        };
        if self.saving.is_some() {
            return Err("a take is being saved; wait until it is finished".into());
        }
        let to = self.free("mcap")?;
        let text = format!("saving {}", to.display());
        self.saving = Some(take.save(to, recorder)?);
        Ok(text)
    }
}

/// Runs work that may wait for a disk on a new thread, and returns the receiver of its result.
fn spawn_writer(
    work: impl FnOnce() -> Result<String, FileError> + Send + 'static,
) -> Receiver<Result<String, FileError>> {
    let (tell, end) = channel();
    let done = tell.clone();
    let run = move || {
        let _ = done.send(work());
    };
    if let Err(e) = thread::Builder::new().name("ca keep".into()).spawn(run) {
        let _ = tell.send(Err(FileError::content(format!("a thread for writing cannot be started: {e}"))));
    }
    end
}

impl Drop for PageFiles {
    /// Finishes all files before the program finishing.
    fn drop(&mut self) {
        self.stop();
        self.take = None;
        for end in self.finishing.drain(..).chain(self.saving.take()) {
            let _ = end.recv();
        }
    }
}
