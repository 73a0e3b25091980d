//! Edit and hear: a model that is saved, or a number of it that is changed, becomes another version of the scene while it plays.
//!
//! Decides that a model is read and compiled on a thread of its own; that one with errors is reported and changes nothing; and that
//! of several changes that came together a wrong one takes no good one along.

use crate::args::{ServeArgs, Source};
use crate::watch::Watch;
use ca_compile::Options;
use ca_haptic::coupling;
use ca_haptic::engine::Setup;
use ca_haptic::version::{ModelText, Version};
use ca_lab::{Failure, load};
use ca_model::diag::Severity;
use ca_model::render;
use ca_view::Drawing;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A version that was made.
pub(super) struct Made {
    pub(super) version: Version,
    pub(super) drawing: Arc<Drawing>,
    /// its warnings, and keys that are softened, or nothing
    pub(super) said: String,
    /// keys are softened, or too stiff
    pub(super) softened: bool,
    /// devices as this version plays them
    pub(super) setups: Vec<Setup>,
}

/// The files that a model takes parts from, and what became of it.
type Making = (Vec<String>, Result<Made, String>);

/// The most numbers that are changed, and the longest name or value of one \[bytes\].
const MOST: usize = 200;
const LONGEST: usize = 300;

/// Makes versions of a model.
pub(super) struct Edit {
    source: Source,
    options: Options,
    /// numbers that were changed since, in order
    changes: Vec<(String, String)>,
    /// those that are being made
    tried: Vec<(String, String)>,
    /// those of the last version that was good
    good: Vec<(String, String)>,
    /// those that were refused together, and are tried one by one
    singly: VecDeque<(String, String)>,
    /// the file, where the model is one
    file: Option<Watch>,
    /// what is being made, and whether something changed meanwhile
    making: Option<Receiver<Making>>,
    again: bool,
    /// the next version begins as at load
    anew: bool,
}

impl Edit {
    pub(super) fn new(args: &ServeArgs, options: &Options) -> Edit {
        let source = args.source.clone();
        let mut file = Watch::of(&source.model);
        if let (Some(file), Ok(loaded)) = (&mut file, crate::load::read(&source.model)) {
            file.also(&load::part_files(&loaded.model));
        }
        Edit {
            file,
            source,
            options: options.clone(),
            changes: Vec::new(),
            tried: Vec::new(),
            good: Vec::new(),
            singly: VecDeque::new(),
            making: None,
            again: false,
            anew: false,
        }
    }

    /// All begins as at load, with the numbers as they are.
    pub(super) fn restart(&mut self) {
        (self.again, self.anew) = (true, true);
    }

    /// A number of the model is to be another, as by `--set`.
    pub(super) fn change(&mut self, name: &str, value: &str) -> Result<(), String> {
        if self.changes.len() >= MOST && !self.changes.iter().any(|c| c.0 == name) {
            return Err(format!("{MOST} numbers are changed already; write them into the file of the model"));
        }
        if name.len().max(value.len()) > LONGEST {
            return Err(format!("`name` and `value` have {LONGEST} bytes at most"));
        }
        put(&mut self.changes, (name.into(), value.into()));
        self.again = true;
        Ok(())
    }

    /// One turn: a version that is ready for these devices, or why there is none.
    pub(super) fn turn(&mut self, setups: &[Setup]) -> Option<Result<Made, String>> {
        self.again |= self.file.as_mut().is_some_and(Watch::is_new);
        if self.file.as_mut().is_some_and(Watch::is_gone) {
            return Some(Err(format!("`{}` is not there any more, or is no file; save it again", self.source.model)));
        }
        let mut made = match self.making.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return None,
            Some(Ok((files, made))) => {
                if let Some(file) = &mut self.file {
                    file.also(&files);
                }
                Some(made)
            }
            Some(Err(TryRecvError::Disconnected)) => Some(Err("the model could not be made: its thread ended".into())),
            None => None,
        };
        self.making = None;
        match made {
            Some(Ok(_)) => self.good.clone_from(&self.tried),
            // changes that are refused are none; those that came since are tried
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
            let (source, changes, options) = (self.source.clone(), self.changes.clone(), self.options.clone());
            let (anew, setups) = (core::mem::take(&mut self.anew), setups.to_vec());
            self.tried.clone_from(&changes);
            let (tell, making) = channel();
            let start = move || {
                let mut files = Vec::new();
                let made = make(&source, &changes, (options, &setups), anew, &mut files);
                let _ = tell.send((files, made));
            };
            if let Err(e) = std::thread::Builder::new().name("ca model".into()).spawn(start) {
                return Some(Err(format!("no thread to make the model: {e}")));
            }
            self.making = Some(making);
        }
        made
    }
}

/// One more change, in the place of an earlier one of the same number.
fn put(changes: &mut Vec<(String, String)>, change: (String, String)) {
    changes.retain(|c| c.0 != change.0);
    changes.push(change);
}

/// Reads and compiles.
fn make(
    source: &Source,
    changes: &[(String, String)],
    (options, setups): (Options, &[Setup]),
    anew: bool,
    files: &mut Vec<String>,
) -> Result<Made, String> {
    let words = |e: Failure| match e {
        Failure::Usage(text) | Failure::Failed(text) => text,
        Failure::Found(found) => render::text(&found.diags, &found.model, false),
        Failure::Stopped => "stopped".into(),
    };
    let mut loaded = crate::load::read(&source.model).map_err(words)?;
    *files = load::part_files(&loaded.model);
    let changes: Vec<_> = source.changes().chain(changes.iter().cloned()).collect();
    for (name, value) in &changes {
        load::set_typed(&mut loaded, name, value).map_err(words)?;
    }
    let mut options = Options { clouds: loaded.clouds.clone(), couplings: Vec::new(), ..options };
    let compiled = load::scene(&loaded, &options).map_err(words)?;
    let met = coupling::meet(compiled, setups, &mut options, |options| load::scene(&loaded, options));
    let (softened, setups) = (met.said(), met.setups(setups));
    let compiled = met.compiled;
    let drawing = Arc::new(Drawing::new(&compiled.scene));
    let mut warnings = compiled.findings;
    warnings.list.retain(|d| d.severity == Severity::Warning);
    let said = if warnings.list.is_empty() { String::new() } else { render::text(&warnings, &loaded.model, false) };
    let said = [said, softened.join("\n")].into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>().join("\n");
    let model = ModelText::of(&loaded.model, changes);
    let version = Version { scene: Arc::new(compiled.scene), model, options, moved: Vec::new(), anew };
    Ok(Made { version, drawing, said, softened: !softened.is_empty(), setups })
}
