//! The loop that plays.

use crate::outcome::Failure;
use crate::term;
use ca_core::scene::Halves;
use ca_io::gesture::Gesture;
use ca_io::perform::Performance;
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

/// Listens for Ctrl-C from now on; without, it ends the process as ever, and leaves unfinished files behind.
pub(crate) fn listen() {
    let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));
}

/// What is done with outputs.
pub(crate) type Sink<'a> = dyn FnMut(&Performance, &[f64]) -> Result<(), Failure> + 'a;

/// The bar of a render that takes longer than somebody would wait, and whether it goes on.
struct Progress {
    bar: Option<ProgressBar>,
    begin: Instant,
    frames: u64,
    show: bool,
}

impl Progress {
    fn new(frames: u64, show: bool) -> Progress {
        Progress { bar: None, begin: Instant::now(), frames, show }
    }

    fn step(&mut self, done: u64) -> Result<(), Failure> {
        if self.show && self.bar.is_none() && self.begin.elapsed() > PATIENCE {
            self.bar = Some(term::progress(self.frames));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
        // what is not finished removes itself
        if stopped() { Err(Failure::Interrupted) } else { Ok(()) }
    }

    fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Plays `frames` ticks. After every `block` of them, `heard` gets their outputs, interleaved.
pub(crate) fn play<'a>(
    p: Performance<'a>,
    frames: u64,
    block: u64,
    show: bool,
    heard: &mut Sink,
) -> Result<Played<'a>, Failure> {
    let mut progress = Progress::new(frames, show);
    let played = ca_lab::play::play(p, frames, block, &mut |p, rows, done| {
        heard(p, rows)?;
        progress.step(done)
    })?;
    progress.end();
    Ok(played)
}

/// As `play`, by two threads.
pub(crate) fn play_halves<'a>(
    p: Performance<'a>,
    halves: &'a Halves,
    gesture: Option<&Gesture>,
    frames: u64,
    show: bool,
    heard: &mut dyn FnMut(&[f64]) -> Result<(), Failure>,
) -> Result<Played<'a>, Failure> {
    let mut progress = Progress::new(frames, show);
    let played = ca_lab::play::play_halves(p, halves, gesture, (frames, BLOCK), &mut |rows, done| {
        heard(rows)?;
        progress.step(done)
    })?;
    progress.end();
    Ok(played)
}
