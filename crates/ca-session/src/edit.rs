//! Edits of the model while it plays: a saved text and changed numbers.
//!
//! The [`VersionCompiler`] compiles; this module decides what is compiled and when. A version with errors is reported and changes
//! nothing. If several changes are refused together, each is tried alone, so that a wrong one does not discard a right
//! one.

use crate::host::{CompileState, CompiledVersion, VersionCompiler};
use crate::refused::Refused;
use ca_core::LiveParam;
use ca_haptic::engine::Setup;
use std::collections::VecDeque;

/// Largest number of changed numbers, and the longest name or value \[bytes\].
const MOST: usize = 200;
const LONGEST: usize = 300;

/// Name and value of a number of the model.
type Number = (String, String);

/// Changes of the numbers, and the present compilation.
pub(crate) struct Edit {
    maker: Box<dyn VersionCompiler>,
    /// Numbers changed since the start, in order.
    changes: Vec<Number>,
    /// Changes in the present compilation.
    tried: Vec<Number>,
    /// Changes in the last valid version.
    good: Vec<Number>,
    /// Changes that were refused together, to be tried one by one.
    singly: VecDeque<Number>,
    /// Something changed since the last compilation began.
    again: bool,
    /// The next version starts as at load.
    anew: bool,
}

impl Edit {
    pub(crate) fn new(maker: Box<dyn VersionCompiler>) -> Edit {
        Edit {
            maker,
            changes: Vec::new(),
            tried: Vec::new(),
            good: Vec::new(),
            singly: VecDeque::new(),
            again: false,
            anew: false,
        }
    }

    /// Starts again as at load, with the present numbers.
    pub(crate) fn restart(&mut self) {
        (self.again, self.anew) = (true, true);
    }

    /// Changes a number of the model, as `--set` does.
    pub(crate) fn change(&mut self, name: &str, value: &str) -> Result<(), Refused> {
        if self.changes.len() >= MOST && !self.changes.iter().any(|c| c.0 == name) {
            return Err(format!("{MOST} values are already changed; write them into the model file").into());
        }
        if name.len().max(value.len()) > LONGEST {
            return Err(format!("`name` and `value` may have at most {LONGEST} bytes each").into());
        }
        self.maker.check(name, value)?;
        put(&mut self.changes, (name.into(), value.into()));
        self.again = true;
        Ok(())
    }

    /// Stores the last valid version with its changes and the values of `live`.
    pub(crate) fn snapshot(&mut self, live: &[LiveParam]) -> Result<(), Refused> {
        self.maker.snapshot(&self.good, live)
    }

    /// Returns a version that was compiled for devices of these setups, or the reason for its failure, and begins the
    /// next compilation. Call it every few milliseconds.
    pub(crate) fn poll(&mut self, setups: &[Setup]) -> Option<Result<Box<CompiledVersion>, Refused>> {
        self.again |= self.maker.is_new();
        if let Some(why) = self.maker.gone() {
            return Some(Err(why.into()));
        }
        let mut made = match self.maker.poll() {
            CompileState::Busy => return None,
            CompileState::Idle => None,
            CompileState::Done(made) => Some(made),
        };
        match made {
            Some(Ok(_)) => self.good.clone_from(&self.tried),
            // refused changes are dropped; later ones are tried
            Some(Err(_)) => {
                let now = core::mem::replace(&mut self.changes, self.good.clone());
                now.into_iter().filter(|c| !self.tried.contains(c)).for_each(|c| put(&mut self.changes, c));
                let new: Vec<_> = self.tried.iter().filter(|c| !self.good.contains(c)).cloned().collect();
                if new.len() > 1 {
                    self.singly.extend(new);
                    made = None;
                }
            }
            None => {}
        }
        if let Some(change) = (!self.again).then(|| self.singly.pop_front()).flatten() {
            put(&mut self.changes, change);
            self.again = true;
        }
        if core::mem::take(&mut self.again) {
            self.tried.clone_from(&self.changes);
            if let Err(why) = self.maker.start(&self.changes, core::mem::take(&mut self.anew), setups) {
                return Some(Err(why));
            }
        }
        made
    }
}

/// Adds a change, replacing an earlier one of the same number.
fn put(changes: &mut Vec<Number>, change: Number) {
    changes.retain(|c| c.0 != change.0);
    changes.push(change);
}
