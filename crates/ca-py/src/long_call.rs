//! Long calls: a new thread computes, while the calling thread checks for signals and reports progress.
//!
//! Eigenvalues, compilation and a render of a fit cannot be interrupted, so Ctrl-C ends the call at once without
//! waiting for them. The computing thread ends at its next check of [`CallProgress`] or when its work is done, and its result
//! is dropped. It never holds the interpreter lock.

use pyo3::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

/// Interval between two checks for signals.
const OFTEN: Duration = Duration::from_millis(20);
/// Time that an interrupted call leaves its work to finish or remove a file.
const GRACE: Duration = Duration::from_millis(60);
/// Stack of a computing thread, as large as for a main thread \[bytes\].
const STACK: usize = 8 << 20;

/// State shared between a call and its computing thread: progress, and a request to stop.
#[derive(Default)]
pub struct CallProgress {
    dropped: AtomicBool,
    done: AtomicU64,
    of: AtomicU64,
}

impl CallProgress {
    /// Reports progress; returns false if the work should stop.
    pub fn goes_on(&self, done: u64, of: u64) -> bool {
        self.of.store(of, Relaxed);
        self.done.store(done, Relaxed);
        self.still()
    }

    /// Returns false if the work should stop.
    pub fn still(&self) -> bool {
        !self.dropped.load(Relaxed)
    }
}

/// Runs `work` on a new thread. A signal or an exception of `progress(done, of)` ends the call early with an error,
/// `ended` ends it with `None`.
pub fn run_unless<R: Send + 'static>(
    py: Python,
    progress: Option<Py<PyAny>>,
    ended: impl Fn() -> bool,
    work: impl FnOnce(&CallProgress) -> R + Send + 'static,
) -> PyResult<Option<R>> {
    let wanted = Arc::new(CallProgress::default());
    let (found, mut ready) = sync_channel(1);
    let computed = wanted.clone();
    let run = move || drop(found.send(work(&computed)));
    let thread = std::thread::Builder::new().name("ca".into()).stack_size(STACK).spawn(run)?;
    let mut reported = (0, 0);
    let mut report = |py: Python| {
        let far = (wanted.done.load(Relaxed), wanted.of.load(Relaxed));
        let news = progress.as_ref().filter(|_| far != reported);
        reported = far;
        news.map_or(Ok(()), |f| f.call1(py, far).map(drop))
    };
    loop {
        let next;
        (next, ready) = py.detach(move || (ready.recv_timeout(OFTEN), ready));
        let stops = match next {
            Ok(found) => return report(py).and_then(|()| py.check_signals()).map(|()| Some(found)),
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => return Ok(None),
            },
            Err(RecvTimeoutError::Timeout) => py.check_signals().and_then(|()| report(py)),
        };
        if stops.is_err() || ended() {
            wanted.dropped.store(true, Relaxed);
            drop(py.detach(move || ready.recv_timeout(GRACE)));
            return stops.map(|()| None);
        }
    }
}

/// Runs `work` on a new thread. A signal or an exception of `progress(done, of)` ends the call early with an error.
pub fn run_detached<R: Send + 'static>(
    py: Python,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&CallProgress) -> R + Send + 'static,
) -> PyResult<R> {
    let found = run_unless(py, progress, || false, work)?;
    found.ok_or_else(|| crate::error::failure(py, ca_lab::Failure::Stopped))
}

/// Waits until `done`, up to `limit`. A signal ends the wait with an error.
pub fn until(py: Python, limit: Duration, done: impl Fn() -> bool) -> PyResult<bool> {
    let begun = Instant::now();
    while !done() {
        if begun.elapsed() > limit {
            return Ok(false);
        }
        py.detach(|| std::thread::sleep(OFTEN));
        py.check_signals()?;
    }
    Ok(true)
}

/// Checks for signals from time to time, for work on the calling thread.
pub struct SignalCheck {
    last: Instant,
    /// Error raised by a signal.
    pub error: Option<PyErr>,
}

impl SignalCheck {
    pub fn new() -> SignalCheck {
        SignalCheck { last: Instant::now(), error: None }
    }

    /// Returns false if a signal ends the work.
    pub fn goes_on(&mut self) -> bool {
        if self.error.is_none() && self.last.elapsed() >= OFTEN {
            self.last = Instant::now();
            let signals = |py: Python| py.check_signals();
            self.error = Python::attach(signals).err();
        }
        self.error.is_none()
    }
}
