//! Halves: a scene played by two threads, a half each.
//!
//! Decides for one exchange in each tick, by two arrays that are written in turn: who is done with a tick writes how the
//! places moved that the other half looks at and then how many ticks it has done, and who begins the next one waits until
//! the other has done as many. Motions alone, of which positions are the sum: what one core wrote and another reads costs
//! far more than an addition. A half is at most one tick ahead, so what is read is never what is being written. Waiting is a loop and no
//! lock: at some tens of microseconds a tick, a thread that sleeps would wake too late. For files, not for devices: in real
//! time the second core belongs to the others that play.

use crate::error::FileError;
use crate::gesture::Gesture;
use crate::length::Length;
use crate::perform::Performance;
use ca_core::scene::{Half, Halves};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

/// Turns of the waiting loop after which it lets others run.
const PATIENCE: u32 = 500;
/// Blocks of outputs that wait to be written.
const AHEAD: usize = 2;

/// What one half tells the other. Aligned, so that what one writes does not take from the other the line it is reading.
#[repr(align(128))]
struct Mailbox {
    /// motions of the places the other half looks at, as bits: after an even and after an odd tick
    numbers: [Vec<AtomicU64>; 2],
    /// ticks done
    done: AtomicU64,
    /// the tick from which on it is silent, since it has diverged; the other half may not have got there yet
    silent_from: AtomicU64,
    /// it plays no more
    gone: AtomicBool,
}

impl Mailbox {
    fn new(shared: usize) -> Mailbox {
        let numbers = || (0..shared).map(|_| AtomicU64::new(0)).collect();
        Mailbox {
            numbers: [numbers(), numbers()],
            done: AtomicU64::new(0),
            silent_from: AtomicU64::new(u64::MAX),
            gone: AtomicBool::new(false),
        }
    }
}

/// Says so where its thread ends, whyever: nobody waits for what will not come.
struct Leaving<'a>(&'a Mailbox);

impl Drop for Leaving<'_> {
    fn drop(&mut self) {
        self.0.gone.store(true, Ordering::Release);
    }
}

/// A half as one thread plays it.
struct Part<'a> {
    half: &'a Half,
    performance: Performance<'a>,
    mine: &'a Mailbox,
    other: &'a Mailbox,
    /// positions of the ghosts, which the tick of this half would move too
    ghosts: Vec<f64>,
    ticks: u64,
}

impl Part<'_> {
    /// Plays a tick; false where the other half is gone.
    fn tick(&mut self) -> bool {
        if self.ticks > 0 && !self.receive() {
            return false;
        }
        self.performance.tick();
        self.ticks += 1;
        let numbers = &self.mine.numbers[self.ticks as usize % 2];
        let s = &self.performance.state;
        let shared = self.half.shared.iter().map(|at| *at as usize);
        for (number, at) in numbers.iter().zip(shared) {
            number.store(s.d[at].to_bits(), Ordering::Relaxed);
        }
        if self.performance.diverged {
            self.mine.silent_from.fetch_min(self.ticks, Ordering::Relaxed);
        }
        self.mine.done.store(self.ticks, Ordering::Release);
        true
    }

    /// Waits for the tick before of the other half, and puts its places where this one looks for them.
    fn receive(&mut self) -> bool {
        let mut turns = 0;
        while self.other.done.load(Ordering::Acquire) < self.ticks {
            if self.other.gone.load(Ordering::Acquire) && self.other.done.load(Ordering::Acquire) < self.ticks {
                return false;
            }
            turns += 1;
            if turns < PATIENCE { std::hint::spin_loop() } else { std::thread::yield_now() }
        }
        // the whole scene would have been silent from this tick on
        self.performance.diverged |= self.other.silent_from.load(Ordering::Relaxed) <= self.ticks;
        let numbers = &self.other.numbers[self.ticks as usize % 2];
        let s = &mut self.performance.state;
        let ghosts = self.half.ghosts.iter().map(|at| *at as usize);
        for ((number, x), at) in numbers.iter().zip(&mut self.ghosts).zip(ghosts) {
            let d = f64::from_bits(number.load(Ordering::Relaxed));
            // as it moves in the other half, bit by bit
            *x += d;
            (s.x[at], s.d[at]) = (*x, d);
        }
        true
    }

    /// Plays a block, its outputs into `rows`.
    fn block(&mut self, ticks: u64, rows: &mut Vec<f64>) -> bool {
        rows.clear();
        for _ in 0..ticks {
            if !self.tick() {
                return false;
            }
            rows.extend_from_slice(&self.performance.state.output);
        }
        true
    }
}

/// What is done with outputs, rows of the whole scene one after the other, and with how many there have been.
pub type Sink<'a, E> = dyn FnMut(&[f64], u64) -> Result<(), E> + 'a;

/// Plays a scene, `whole`, that has not begun, as its `halves`. `gesture` is the gesture of `whole`. After every `block` of
/// samples, `heard` gets their outputs. Returns `whole` at its end. If the sound has died away before the length is over, the
/// second half is some blocks ahead, and so are its places.
///
/// # Errors
/// Those of `heard`, which end it; where the gesture does not fit.
pub fn play<'a, E: From<FileError>>(
    mut whole: Performance<'a>,
    halves: &'a Halves,
    gesture: Option<&Gesture>,
    (length, block): (impl Into<Length>, u64),
    heard: &mut Sink<E>,
) -> Result<Performance<'a>, E> {
    let boxes = halves.halves.each_ref().map(|h| Mailbox::new(h.shared.len()));
    let [first, second] = &halves.halves;
    let part = |half: &'a Half| {
        let mut p = Performance::new(&half.scene, gesture)?;
        // a start takes all of a scene into account
        for [here, there] in half.places.iter().map(|at| at.map(|at| at as usize)) {
            (p.state.x[here], p.state.d[here]) = (whole.state.x[there], whole.state.d[there]);
        }
        Ok::<_, FileError>(p)
    };
    let (a, b) = (part(first)?, part(second)?);
    let placed = |half: &Half, p: &Performance| half.ghosts.iter().map(|at| p.state.x[*at as usize]).collect();
    let [of_a, of_b]: [Vec<f64>; 2] = [placed(first, &a), placed(second, &b)];
    let mut a = Part { half: first, performance: a, mine: &boxes[0], other: &boxes[1], ghosts: of_a, ticks: 0 };
    let mut b = Part { half: second, performance: b, mine: &boxes[1], other: &boxes[0], ghosts: of_b, ticks: 0 };
    let mut length = length.into();
    let (shape, frames) = ((whole.scene.n_out, whole.scene.channels), length.frames);
    let (send, receive) = sync_channel(AHEAD);
    let blocks = || (0..frames.div_ceil(block)).map(move |i| block.min(frames - i * block));
    let played = std::thread::scope(|threads| {
        let beside = threads.spawn(|| {
            let _leaving = Leaving(b.mine);
            blocks().all(|n| sent(&mut b, n, &send));
            // nobody waits for a block that will not come
            drop(send);
        });
        let played = {
            let _leaving = Leaving(a.mine);
            mixed(&mut a, (second, &receive), shape, blocks(), (heard, &mut length))
        };
        // nobody takes its blocks any more
        drop(receive);
        if let Err(panic) = beside.join() {
            std::panic::resume_unwind(panic);
        }
        played
    });
    played?;
    for part in [&a, &b] {
        for [here, there] in part.half.own.iter().map(|at| at.map(|at| at as usize)) {
            (whole.state.x[there], whole.state.d[there]) =
                (part.performance.state.x[here], part.performance.state.d[here]);
        }
    }
    whole.state.placed();
    whole.ended_as(a.performance);
    Ok(whole)
}

/// Plays a block of the second half and hands its outputs over.
fn sent(part: &mut Part, n: u64, to: &SyncSender<Vec<f64>>) -> bool {
    let mut rows = Vec::with_capacity(n as usize * part.performance.scene.n_out);
    part.block(n, &mut rows) && to.send(rows).is_ok()
}

/// Plays the blocks of the first half until the sound has died away, and hands them on with the blocks of the second.
fn mixed<E>(
    part: &mut Part,
    (second, receive): (&Half, &Receiver<Vec<f64>>),
    (n_out, channels): (usize, usize),
    blocks: impl Iterator<Item = u64>,
    (heard, length): (&mut Sink<E>, &mut Length),
) -> Result<(), E> {
    let (mut rows, mut all) = (Vec::new(), Vec::new());
    let mut done = 0;
    for n in blocks {
        if !part.block(n, &mut rows) {
            break;
        }
        let Ok(others) = receive.recv() else { break };
        all.clear();
        all.resize(n as usize * n_out, 0.0);
        for (half, rows) in [(part.half, &rows), (second, &others)] {
            let own = half.outputs.len();
            for (from, to) in rows.chunks_exact(own.max(1)).zip(all.chunks_exact_mut(n_out.max(1))) {
                for (v, at) in from.iter().zip(&half.outputs) {
                    if let Some(at) = at {
                        to[*at as usize] = *v;
                    }
                }
            }
        }
        done += n;
        heard(&all, done)?;
        if !length.hear(&all, n_out, channels) {
            break;
        }
    }
    Ok(())
}
