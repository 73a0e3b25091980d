//! Plays a scene in this process, with its page.

use crate::long_call::until;
use crate::{error, model};
use ca_haptic::control::{Given, Reply, Request};
use ca_haptic::serve::Shared;
use ca_lab::Failure;
use ca_live::{ControlRequest, Listener};
use ca_model::diag::Diags;
use ca_model::{Model, render};
use ca_take::Original;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Longest wait for the page, and for the answer to a request.
const PATIENCE: Duration = Duration::from_secs(60);
const ANSWER: Duration = Duration::from_secs(5);
/// Number of stored messages; beyond it, the older half is dropped.
const MESSAGES: usize = 1000;

/// State shared between a performance and Python.
#[derive(Default)]
struct Messages {
    lines: Mutex<Vec<String>>,
    address: Mutex<Option<String>>,
    shared: Mutex<Option<Arc<Shared>>>,
    stopped: AtomicBool,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Messages {
    fn add(&self, text: String) {
        let mut lines = locked(&self.lines);
        lines.push(text);
        if lines.len() > MESSAGES {
            lines.drain(..MESSAGES / 2);
        }
    }
}

impl Listener for Messages {
    fn note(&self, text: &str) {
        self.add(format!("note: {text}"));
    }

    fn warning(&self, text: &str) {
        self.add(format!("warning: {text}"));
    }

    fn error(&self, text: &str) {
        self.add(format!("error: {text}"));
    }

    fn findings(&self, findings: &Diags, model: &Model) {
        self.add(render::text(findings, model, false).trim_end().into());
    }

    fn progress(&self, text: &str) {
        self.note(text);
    }

    fn begins(&self, shared: &Arc<Shared>) {
        *locked(&self.shared) = Some(shared.clone());
        // a stop may come first
        if self.stopped.load(SeqCst) {
            shared.stop.store(true, Relaxed);
        }
    }

    fn page_opened(&self, address: &str) {
        *locked(&self.address) = Some(address.into());
    }
}

/// A performance on a thread of this process.
#[pyclass(module = "cordis_anima._core", frozen)]
pub struct Performance {
    messages: Arc<Messages>,
    requests: Mutex<Sender<ControlRequest>>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

#[pymethods]
impl Performance {
    /// Plays a model under the name `name`, with arguments of `ca play`.
    #[new]
    fn new(py: Python, model: PyRef<model::Model>, name: &str, args: Vec<OsString>) -> PyResult<Performance> {
        let whole = model.whole();
        drop(model);
        let made = py.detach(|| {
            let Original { mut loaded, changes, .. } = Original::of(&whole)?;
            // the page shows this name
            loaded.name = name.into();
            ca_cli::play_request(name, args, Arc::new(move || Ok(loaded.clone())), changes)
        });
        let mut request = made.map_err(|e| error::failure(py, e))?;
        // a memory lock would pin all memory of Python
        request.thread.lock = false;
        let (requests, asked) = channel();
        request.requests = Some(asked);
        let messages = Arc::new(Messages::default());
        let listener = messages.clone();
        let play = move || {
            let heard: Arc<dyn Listener> = listener.clone();
            match ca_live::play(request, &heard) {
                Ok(_) => {}
                Err(Failure::Found(found)) => listener.add(error::findings(&found.diags, &found.model).1),
                Err(Failure::Usage(why) | Failure::Failed(why)) => listener.error(&why),
                Err(Failure::Stopped) => listener.error("stopped"),
            }
        };
        let thread = std::thread::Builder::new().name("ca play".into()).spawn(play)?;
        let made = Performance { messages, requests: Mutex::new(requests), thread: Mutex::new(Some(thread)) };
        let opened = until(py, PATIENCE, || made.address().is_some() || !made.is_playing());
        if !matches!(opened, Ok(true)) {
            made.stop(py);
        }
        opened?;
        Ok(made)
    }

    /// Address of the page, once it is open.
    fn address(&self) -> Option<String> {
        locked(&self.messages.address).clone()
    }

    fn is_playing(&self) -> bool {
        locked(&self.thread).as_ref().is_some_and(|t| !t.is_finished())
    }

    /// Messages so far, one per line.
    fn lines(&self) -> Vec<String> {
        locked(&self.messages.lines).clone()
    }

    /// Changes numbers as `ca set` does; returns the answer.
    fn set(&self, py: Python, values: Vec<(String, String)>) -> PyResult<String> {
        let values = values.into_iter().map(|(name, value)| (name, Given::Text(value))).collect();
        let (tell, reply) = channel();
        let sent = locked(&self.requests).send((Request::Set { values }, tell));
        let answer = sent.ok().and_then(|()| py.detach(move || reply.recv_timeout(ANSWER).ok()));
        match answer {
            Some(Reply { ok: true, text, .. }) => Ok(text),
            Some(reply) => Err(error::usage(py, &reply.text)),
            None => Err(error::failure(
                py,
                Failure::Failed("the scene does not answer; if it has stopped, play it again".into()),
            )),
        }
    }

    /// Stops it, and waits until its files are complete.
    fn stop(&self, py: Python) {
        self.messages.stopped.store(true, SeqCst);
        if let Some(shared) = &*locked(&self.messages.shared) {
            shared.stop.store(true, Relaxed);
        }
        let thread = locked(&self.thread).take();
        py.detach(|| thread.map(JoinHandle::join));
    }
}
