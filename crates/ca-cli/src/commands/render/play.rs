//! Plays a performance with a progress bar, until its end or Ctrl-C.

use crate::outcome::Failure;
use crate::term;
use ca_io::perform::Performance;
use ca_lab::play::Length;
pub(crate) use ca_lab::play::{Audit, BLOCK, Played, audit};
use indicatif::ProgressBar;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);
/// Playing time after which the progress bar appears.
const PATIENCE: Duration = Duration::from_millis(500);

/// Returns true if Ctrl-C was pressed since [`listen`].
pub(crate) fn stopped() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// Handles Ctrl-C from now on. Without this, Ctrl-C ends the process at once and leaves unfinished files. A second
/// Ctrl-C still ends the process, because a pipe without a reader blocks it.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

pub(crate) type Sink<'a> = dyn FnMut(&Performance, &[f64]) -> Result<(), Failure> + 'a;

/// Progress bar for plays longer than half a second, and check for Ctrl-C.
pub(crate) struct Progress {
    bar: Option<ProgressBar>,
    begin: Instant,
    frames: u64,
    show: bool,
}

impl Progress {
    pub(crate) fn new(frames: u64, show: bool) -> Progress {
        Progress { bar: None, begin: Instant::now(), frames, show }
    }

    /// Shows the progress. Returns false after Ctrl-C.
    pub(crate) fn goes_on(&mut self, done: u64) -> bool {
        if self.show && self.bar.is_none() && self.begin.elapsed() > PATIENCE {
            self.bar = Some(term::progress(self.frames));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
        let goes_on = !stopped();
        if !goes_on {
            self.end();
        }
        goes_on
    }

    pub(crate) fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Plays for a length. `heard` receives the interleaved outputs after every `block` samples.
pub(crate) fn play<'a>(
    p: Performance<'a>,
    length: Length,
    block: u64,
    show: bool,
    heard: &mut Sink,
) -> Result<Played<'a>, Failure> {
    let mut progress = Progress::new(length.frames, show);
    let played = ca_lab::play::play(p, length, block, &mut |p, rows, done| {
        heard(p, rows)?;
        // unfinished files remove themselves
        if progress.goes_on(done) { Ok(()) } else { Err(Failure::from(ca_lab::Failure::Stopped)) }
    })?;
    progress.end();
    Ok(played)
}
