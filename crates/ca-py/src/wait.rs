//! Long calls: how far they are, and whether anybody still wants them.

use pyo3::prelude::*;
use std::time::{Duration, Instant};

/// Between two looks at signals: often enough for a hand on Ctrl-C, seldom enough to cost nothing.
const OFTEN: Duration = Duration::from_millis(50);

/// Asks now and then whether to go on, from a call that holds no lock of the interpreter.
pub struct Wait {
    progress: Option<Py<PyAny>>,
    last: Instant,
    /// why it ended
    pub error: Option<PyErr>,
}

impl Wait {
    /// With what is reported `progress(done, of)`.
    pub fn new(progress: Option<Py<PyAny>>) -> Wait {
        Wait { progress, last: Instant::now(), error: None }
    }

    /// False where a signal or the callback ends the call.
    pub fn goes_on(&mut self, done: u64, of: u64) -> bool {
        if self.error.is_some() {
            return false;
        }
        if done < of && self.last.elapsed() < OFTEN {
            return true;
        }
        self.last = Instant::now();
        let reported = Python::attach(|py| {
            py.check_signals()?;
            self.progress.as_ref().map_or(Ok(()), |f| f.call1(py, (done, of)).map(drop))
        });
        self.error = reported.err();
        self.error.is_none()
    }
}
