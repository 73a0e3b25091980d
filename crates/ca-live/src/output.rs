//! Sinks of a performance: the messages, the sound file and the take, each written on a separate thread.

use crate::request::Listener;
use ca_core::Scene;
use ca_haptic::rt::RtRequest;
use ca_haptic::serve::{AsyncSink, BufferLimits, Notice, Shared, Sink, SinkStreams, Summary, WavSink};
use ca_haptic::take::{Finished, Header, TakeWriter};
use ca_io::format::Format;
use ca_io::sound::{WavOut, Written};
use ca_io::{FileError, atomic_file};
use ca_lab::Failure;
use ca_lab::load::has_extension;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Longest wait at the end for a blocked terminal.
const TERMINAL: Duration = Duration::from_secs(1);

/// Checks the path for the sound of a performance. Refuses extensions other than `.wav`, and standard output, because
/// the summary goes there.
///
/// # Errors
/// Returns [`Failure::Usage`] with the reason.
pub fn check_wav_path(path: &Path) -> Result<(), Failure> {
    if atomic_file::is_stdout(path) {
        let what = format!("`{}`: standard output is used for the summary", path.display());
        return Err(Failure::Usage(format!("{what}; give a `.wav` file or a FIFO")));
    }
    // a device such as /dev/null does not need an extension
    let plain = !path.exists() || path.is_file();
    if plain && !has_extension(path, "wav") {
        let what = format!("`{}`: sound is written as WAV", path.display());
        return Err(Failure::Usage(format!("{what}; give the file the extension `.wav`")));
    }
    Ok(())
}

struct Words(Arc<dyn Listener>);

impl Sink for Words {
    fn streams(&self) -> SinkStreams {
        SinkStreams::MESSAGES
    }

    fn notice(&mut self, notice: &Notice) -> Result<(), FileError> {
        if notice.bad {
            self.0.warning(&notice.text);
        } else {
            self.0.progress(&notice.text);
        }
        Ok(())
    }
}

/// All sinks, and the files behind them.
pub(crate) struct Output {
    sinks: Vec<Box<dyn Sink>>,
    words: Option<AsyncSink<Words>>,
    sound: Option<AsyncSink<WavSink>>,
    take: Option<AsyncSink<TakeWriter>>,
    /// Dropped after `take`, so that the file is closed before it is removed.
    unplayed: Unplayed,
}

/// Path of a take without frames. The file is removed if the performance does not begin.
struct Unplayed(Option<PathBuf>);

impl Drop for Unplayed {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            let _ = std::fs::remove_file(path);
        }
    }
}

impl Output {
    /// Opens the sink for messages. If `waits` is true, the recorder calls the listener directly instead of through a
    /// thread.
    pub(crate) fn open(listener: &Arc<dyn Listener>, waits: bool, capacity: BufferLimits) -> Result<Output, Failure> {
        let mut output = Output { sinks: Vec::new(), words: None, sound: None, take: None, unplayed: Unplayed(None) };
        let words = Words(listener.clone());
        if waits {
            output.sinks.push(Box::new(words));
        } else {
            output.words = Some(output.aside("ca terminal", words, (capacity, RtRequest::default()))?);
        }
        Ok(output)
    }

    pub(crate) fn sinks(&mut self) -> &mut Vec<Box<dyn Sink>> {
        &mut self.sinks
    }

    pub(crate) fn sound(
        &mut self,
        path: Option<&Path>,
        scene: &Scene,
        thread: (BufferLimits, RtRequest),
    ) -> Result<(), Failure> {
        let Some(path) = path else { return Ok(()) };
        if scene.counts.channels == 0 {
            return Err(Failure::Usage(
                "-o: nothing to write, because the model lacks an output; add one with `[SOX]`".into(),
            ));
        }
        check_wav_path(path)?;
        let out = WavOut::create(path, scene.rate, scene.counts.channels, Format::F32)?;
        self.sound = Some(self.aside("ca sound", WavSink::new(out, scene.counts.channels), thread)?);
        Ok(())
    }

    pub(crate) fn take(
        &mut self,
        path: Option<&Path>,
        header: impl FnOnce() -> Header,
        scene: &Scene,
        thread: (BufferLimits, RtRequest),
    ) -> Result<(), Failure> {
        let Some(path) = path else { return Ok(()) };
        let writer = TakeWriter::create(path, &header(), scene)?;
        self.unplayed.0 = Some(path.into());
        self.take = Some(self.aside("ca take", writer, thread)?);
        Ok(())
    }

    pub(crate) fn has_take(&self) -> bool {
        self.take.is_some()
    }

    /// Marks the performance as begun, so that its take is kept.
    pub(crate) fn begun(&mut self) {
        self.unplayed.0 = None;
    }

    /// Returns the names of the file threads, with the scheduling granted by the system.
    pub(crate) fn granted(&self) -> Vec<(String, String)> {
        let sound = self.sound.as_ref().map(|w| ("sound file".to_string(), w.granted().to_string()));
        let take = self.take.as_ref().map(|t| ("take".to_string(), t.granted().to_string()));
        sound.into_iter().chain(take).collect()
    }

    /// Waits for pending messages, at most [`TERMINAL`].
    pub(crate) fn leave_terminal(&mut self) {
        if let Some(words) = self.words.take() {
            words.end_within(TERMINAL);
        }
    }

    /// Closes the files and adds failures to the summary.
    pub(crate) fn finish(
        mut self,
        shared: &Shared,
        summary: &mut Summary,
        listener: &dyn Listener,
    ) -> (Option<Written>, Option<Finished>) {
        // records lost because the rings were full, or because the take was written too slowly
        let waited = self.take.as_ref().map_or([0; 3], AsyncSink::lost);
        let lost = std::array::from_fn(|k| shared.lost()[k] + waited[k]);
        let mut broken = |e: FileError| {
            listener.error(&e.to_string());
            summary.broken.push(e.to_string());
        };
        let written = self.sound.take().map(|w| w.end().and_then(|w| w.map(WavSink::finish).transpose()));
        let written = written.and_then(|w| w.map_err(&mut broken).ok().flatten());
        let finished = self.take.take().map(|t| t.end().and_then(|t| t.map(|t| t.finish(lost)).transpose()));
        let finished = finished.and_then(|t| t.map_err(&mut broken).ok().flatten());
        if let Some(lost) = finished.as_ref().map(|t| t.lost).filter(|n| *n > 0) {
            let what = format!("{lost} records or samples were lost because a buffer was full");
            listener.warning(&format!("the take is incomplete: {what}"));
        }
        (written, finished)
    }

    /// Adds a sink with a writer thread.
    fn aside<T: Sink + Send + 'static>(
        &mut self,
        name: &str,
        sink: T,
        (capacity, request): (BufferLimits, RtRequest),
    ) -> Result<AsyncSink<T>, Failure> {
        let (line, aside) = AsyncSink::start(name, sink, capacity, request)?;
        self.sinks.push(Box::new(line));
        Ok(aside)
    }
}
