//! The loop that plays, and the twin that is audited.

use crate::{Failure, term};
use ca_core::Scene;
use ca_core::energy::Ledger;
use ca_haptic::gesture::Gesture;
use ca_haptic::perform::{Performance, WILD};
use ca_haptic::probe::ProbeOut;
use ca_haptic::sound::{WavOut, Written};
use indicatif::ProgressBar;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Ticks between two writes of a render.
pub(crate) const BLOCK: u64 = 1024;
/// Somebody pressed Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);
/// How long a render may last unseen.
const PATIENCE: Duration = Duration::from_millis(500);

/// What playing left behind.
pub(crate) struct Played<'a> {
    pub performance: Performance<'a>,
    /// time spent
    pub wall: Duration,
    /// the tick at which it was found to have blown up
    pub broke: Option<u64>,
    /// the book at the end, or before anything left its range
    pub energy: Option<Ledger>,
    /// ticks in the book
    pub energy_ticks: u64,
}

/// What is done with outputs.
pub(crate) type Sink<'a> = dyn FnMut(&Performance, &[f64]) -> Result<(), Failure> + 'a;

/// Plays `frames` ticks. After every `block` of them, `heard` gets their outputs, interleaved.
pub(crate) fn play<'a>(
    mut p: Performance<'a>,
    frames: u64,
    block: u64,
    show: bool,
    heard: &mut Sink,
) -> Result<Played<'a>, Failure> {
    let n_out = p.scene.n_out;
    let mut rows = Vec::with_capacity(block as usize * n_out);
    let mut bar: Option<ProgressBar> = None;
    let mut last_good: Option<(Ledger, u64)> = None;
    let begin = Instant::now();
    let mut done = 0;
    // without a handler Ctrl-C ends the process as ever, and leaves the unfinished file behind
    let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));
    while done < frames {
        if STOP.load(Ordering::Relaxed) {
            // what is not finished removes itself
            return Err(Failure::Interrupted);
        }
        let block = block.min(frames - done);
        rows.clear();
        for _ in 0..block {
            keep_book(&p, &mut last_good);
            p.tick();
            rows.extend_from_slice(&p.state.output[..n_out]);
        }
        heard(&p, &rows)?;
        done += block;
        if show && bar.is_none() && begin.elapsed() > PATIENCE {
            bar = Some(term::progress(frames));
        }
        if let Some(bar) = &bar {
            bar.set_position(done);
        }
    }
    let wall = begin.elapsed();
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    // what blew up between two looks at the state is found here at the latest
    p.wild |= !p.state.is_sound(WILD);
    let broke = p.wild.then_some(p.state.tick);
    let (energy, energy_ticks) = match last_good {
        Some((book, tick)) => (Some(book), tick),
        None => (p.state.ledger.clone(), p.state.tick),
    };
    // a tick is booked when the next one begins
    let energy_ticks = energy_ticks.saturating_sub(1);
    Ok(Played { performance: p, wall, broke, energy, energy_ticks })
}

/// Where the outputs of a render go.
pub(crate) struct Files {
    pub wav: WavOut,
    /// files of probes, each with the number of its columns
    pub probes: Vec<(ProbeOut, usize)>,
    pub channels: usize,
    /// what waits to be written: sound, then one list for each probe
    pub waiting: Vec<Vec<f64>>,
}

impl Files {
    /// Rows of all outputs.
    pub fn write(&mut self, rows: &[f64]) -> Result<(), Failure> {
        let columns: usize = self.probes.iter().map(|p| p.1).sum();
        self.waiting.resize(1 + self.probes.len(), Vec::new());
        self.waiting.iter_mut().for_each(Vec::clear);
        for row in rows.chunks_exact(self.channels + columns) {
            let mut rest = row;
            let widths = [self.channels].into_iter().chain(self.probes.iter().map(|p| p.1));
            for (list, n) in self.waiting.iter_mut().zip(widths) {
                let (own, others) = rest.split_at(n);
                list.extend_from_slice(own);
                rest = others;
            }
        }
        self.wav.write(&self.waiting[0])?;
        for ((file, _), values) in self.probes.iter_mut().zip(&self.waiting[1..]) {
            file.write(values)?;
        }
        Ok(())
    }

    /// Completes all of them.
    pub fn finish(self) -> Result<Written, Failure> {
        let written = self.wav.finish()?;
        for (file, _) in self.probes {
            file.finish()?;
        }
        Ok(written)
    }
}

/// Where a book is kept and the positions have just left every range: the book as it was.
fn keep_book(p: &Performance, last_good: &mut Option<(Ledger, u64)>) {
    if let (Some(book), None, false) = (&p.state.ledger, &*last_good, p.wild) {
        if !p.state.is_sound(WILD) {
            *last_good = Some((book.clone(), p.state.tick));
        }
    }
}

/// An energy book, and how much time it covers.
pub(crate) struct Audit {
    pub book: Ledger,
    pub ticks: u64,
    /// whether it was kept all the time
    pub whole: bool,
}

/// Modules times ticks the audited twin may take: a second of a thousand-mass string. Larger scenes are audited for
/// less, and the summary says for how long.
const AUDITED: u64 = 100_000_000;

/// Plays the first second once more with the book kept, up to the last tick before any blow-up.
pub(crate) fn audit(twin: &Scene, gesture: Option<&Gesture>, frames: u64) -> Option<Audit> {
    let afford = AUDITED / (twin.n_mat + twin.n_lia).max(1) as u64;
    let ticks = frames.min(twin.rate as u64).min(afford).max(1);
    let mut p = Performance::new(twin, gesture).ok()?;
    while p.state.tick < ticks + 1 && p.state.is_sound(WILD) {
        p.tick();
    }
    let booked = p.state.tick.saturating_sub(1);
    p.state.ledger.map(|book| Audit { book, ticks: booked, whole: false })
}
