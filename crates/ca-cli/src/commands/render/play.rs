//! The loop that plays.

use crate::outcome::Failure;
use crate::term;
use ca_io::perform::Performance;
use ca_lab::play::Length;
pub(crate) use ca_lab::play::{Audit, BLOCK, Played, audit};
use indicatif::ProgressBar;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Somebody pressed Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);
/// How long a render may last unseen.
const PATIENCE: Duration = Duration::from_millis(500);

/// Whether somebody wants no more, since [`listen`].
pub(crate) fn stopped() -> bool {
    STOP.load(Ordering::Relaxed)
}

/// Listens for Ctrl-C from now on; without, it ends the process as ever, and leaves unfinished files behind. A second Ctrl-C
/// does that too, since a pipe without a reader blocks the process.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    });
}

/// What is done with outputs.
pub(crate) type Sink<'a> = dyn FnMut(&Performance, &[f64]) -> Result<(), Failure> + 'a;

/// The progress bar of a play longer than half a second, and whether the play goes on.
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

    /// Shows how much is done. False after Ctrl-C.
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

    /// Takes the bar away.
    pub(crate) fn end(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Plays for a length. After every `block` of them, `heard` gets their outputs, interleaved.
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
        // what is not finished removes itself
        if progress.goes_on(done) { Ok(()) } else { Err(Failure::from(ca_lab::Failure::Stopped)) }
    })?;
    progress.end();
    Ok(played)
}
